"""The stub file has the names, the parameters and the defaults that the module has, and everything is documented."""
import ast
import inspect
import re

import pytest

import trunnion
from conftest import ROOT

STUB = ast.parse((ROOT / 'bindings/python/trunnion/__init__.pyi').read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
PUBLIC = sorted(trunnion.__all__)


def members(node):
    return {m.name for m in node.body if isinstance(m, ast.FunctionDef)} | {
        m.target.id for m in node.body if isinstance(m, ast.AnnAssign)}


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
    signature = inspect.signature(getattr(trunnion, name))
    names = [p.name for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    assert names == [a.arg for a in FUNCTIONS[name].args.args]
