"""Machine, setup and controller files given as nested dicts."""
from collections.abc import Mapping


def _quoted(text):
    escapes = {'"': '\\"', '\\': '\\\\', '\n': '\\n', '\r': '\\r', '\t': '\\t'}
    return '"' + ''.join(escapes.get(c, c if c >= ' ' and c != '\x7f' else f'\\u{ord(c):04x}') for c in str(text)) + '"'


def _value(value):
    if isinstance(value, Mapping):
        return '{ ' + ', '.join(f'{_quoted(key)} = {_value(inner)}' for key, inner in value.items()) + ' }'
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if hasattr(value, 'tolist'):
        return _value(value.tolist())
    if isinstance(value, (list, tuple)):
        return '[' + ', '.join(_value(inner) for inner in value) + ']'
    return repr(value)


def text_of(mapping):
    """The text of a TOML file with these keys."""
    return ''.join(f'{_quoted(key)} = {_value(value)}\n' for key, value in mapping.items())
