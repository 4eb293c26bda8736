"""The exception of the module."""


class Error(Exception):
    """What went wrong, with the fields of its Diagnostic.

    `str()` gives one line: place, code, text, value, limit and what to do. docs/diagnostics.md lists all codes; PY0001 to
    PY0004 are about arguments of the module's own functions and name the argument.
    """

    def __init__(self, diagnostic):
        super().__init__(str(diagnostic))
        self.diagnostic = diagnostic

    def __reduce__(self):
        return type(self), (self.diagnostic,)

    def __getattr__(self, name):
        if name in ('code', 'text', 'value', 'limit', 'hint', 'file', 'line', 'column', 'path_length_mm', 'severity'):
            return getattr(self.diagnostic, name)
        raise AttributeError(name)
