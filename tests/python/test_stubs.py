"""The stub files have the names, the parameters and the defaults that the modules have, and everything is documented."""
import ast
import inspect
import re

import pytest

import trunnion
from conftest import ROOT
from trunnion import study

STUBS = ROOT / 'bindings/python/trunnion'
STUB, STUDY = (ast.parse((STUBS / name).read_text()) for name in ('__init__.pyi', 'study.pyi'))
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
PUBLIC = sorted(trunnion.__all__)


def members(node):
    return {m.name for m in node.body if isinstance(m, ast.FunctionDef)} | {
        m.target.id for m in node.body if isinstance(m, ast.AnnAssign)}


def default_of(node):
    """A default that the stub says, or the node of one that it leaves out as `...`."""
    try:
        return ast.literal_eval(node)
    except ValueError:
        return node


def parameters_of(node):
    """Names and defaults of a stub's function without self: {name: its default, or `empty`}."""
    empty, arguments = inspect.Parameter.empty, node.args
    defaults = [empty] * (len(arguments.args) - len(arguments.defaults)) + [default_of(d) for d in arguments.defaults]
    out = dict(zip((a.arg for a in arguments.args), defaults))
    out |= {a.arg: empty if d is None else default_of(d) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults)}
    out.pop('self', None)
    return out


def given_of(thing):
    """The same of what Python runs, without **options."""
    return {p.name: p.default for p in inspect.signature(thing).parameters.values() if p.kind is not p.VAR_KEYWORD and p.name != 'self'}


def test_the_stub_has_the_names_of_the_module():
    assert sorted([*CLASSES, *FUNCTIONS]) == PUBLIC
    assert {name for name, thing in vars(trunnion).items() if not name.startswith('_') and not inspect.ismodule(thing)} == set(PUBLIC)


@pytest.mark.parametrize('name', sorted(set(CLASSES) - {'Error'}))
def test_the_stub_has_the_members_of_a_class(name):
    there = {m for m in vars(getattr(trunnion, name)) if not m.startswith('_')}
    special = {m for m in vars(getattr(trunnion, name)) if m in ('__call__', '__len__', '__getitem__')}
    stub = members(CLASSES[name])
    assert {m for m in stub if m != '__init__'} == there | special
    for member in there | special - {'__len__', '__getitem__'}:
        assert getattr(trunnion, name).__dict__[member].__doc__, f'{name}.{member} is not documented'


@pytest.mark.parametrize('name', PUBLIC)
def test_documented(name):
    thing = getattr(trunnion, name)
    text = inspect.getdoc(thing)
    assert text and len(text) > 20
    if name in FUNCTIONS:
        assert 'Returns\n-------' in text, name
        if FUNCTIONS[name].args.kwonlyargs and '**options' in str(inspect.signature(thing)):
            for argument in FUNCTIONS[name].args.kwonlyargs:
                assert re.search(rf'\b{argument.arg}\b', text) or 'As ' in text or 'as ' in text, argument.arg


@pytest.mark.parametrize('name', sorted(FUNCTIONS))
def test_positional_parameters_are_those_of_the_stub(name):
    stub = parameters_of(FUNCTIONS[name])
    given = given_of(getattr(trunnion, name))
    assert list(given) == [a.arg for a in FUNCTIONS[name].args.args]
    assert {n: stub[n] for n in given} == given


@pytest.mark.parametrize('name', sorted(set(CLASSES) - {'Error'}))
def test_methods_take_what_the_stub_says(name):
    for node in CLASSES[name].body:
        method = getattr(trunnion, name).__dict__.get(getattr(node, 'name', None))
        text = getattr(method, '__doc__', None) or ''
        if not isinstance(node, ast.FunctionDef) or node.decorator_list or not text.startswith(node.name + '('):
            continue
        stub = parameters_of(node)
        for argument, default in given_of(method).items():
            assert default == stub[argument], f'{name}.{node.name}: {argument}'


def test_the_stub_of_studies():
    there = {node.name: node for node in STUDY.body if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith('_')}
    assert sorted(there) == sorted(study.__all__)
    for name, node in there.items():
        thing = getattr(study, name)
        functions = [(node, thing)] if isinstance(node, ast.FunctionDef) else [
            (m, getattr(thing, m.name)) for m in node.body if isinstance(m, ast.FunctionDef) and not m.decorator_list]
        for stub, given in functions:
            assert parameters_of(stub) == given_of(given), f'{name}.{stub.name}'
        if isinstance(node, ast.ClassDef):
            public = {m for m, value in vars(thing).items() if not m.startswith('_') and (callable(value) or isinstance(value, property))}
            assert public <= members(node), name
