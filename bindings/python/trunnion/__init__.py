"""Trunnion: 5-axis part programs into jerk-limited axis setpoints that a machine can really make.

Lengths are mm, angles degrees, times s, feeds mm/min, as the names of arguments and columns say. Arrays are numpy's:
float64 in rows is taken without a copy; what is given back is memory of the library, not a copy of it. What is wrong is an
`Error` with a code, the place and what to do.

    import trunnion
    machine, setup = trunnion.machine('xyzac-trt'), trunnion.setup('setup.toml')
    program = trunnion.read_program('part.ngc', machine=machine)
    plan = trunnion.plan(program, machine, setup)
    plan['X_mm'], plan.cycle_time_s
"""
from collections.abc import Mapping as _Mapping

from . import _core
from ._core import (BsplineCurve, BsplineSurface, Controller, Diagnostic, DualCorner, DualPath, DualSpline, Face,
                    FaceList, FeedProfile, FlankTool, GuidedSurface, GuidingSurface, Kinematics, LivePlanner, Machine,
                    OrientationSurface, ParameterLink, PartBody, Plan, Prediction, Program, Setup, Stretch,
                    SurfacePlan, Tool, __version__, avoid_pole, check, chord_steps, compensate_deflection, connect,
                    corner_curve, deform_flank, deform_flank_path, deviation_map, flat_interval_mm, move_surface,
                    move_surface_ahead, plan, plan_stretch, plan_surface, predict, program_from_poses,
                    programmed_poses, read_faces, read_program, read_program_text, reduce_rotary, singular_cones,
                    smooth, stretches, two_point_poses)
from ._error import Error
from ._toml import text_of as _text_of


def machine(source):
    """A machine.

    Parameters
    ----------
    source : str, os.PathLike or dict
        The name of a shipped one (`machines()`), a machine file, or the keys of one: quantities are text with a unit,
        `{'chain': 'X Y Z', 'axes': {'X': {'range': ['0 mm', '500 mm'], 'max_velocity': '30 m/min', …}, …}}`.

    Returns
    -------
    Machine

    Raises
    ------
    Error
        FILE0101 to FILE0113, BASE0001 to BASE0004, MACH0101 to MACH0103 with the line.
    """
    if isinstance(source, _Mapping):
        return _core.read_machine_text(_text_of(source), 'machine')
    return _core.find_machine(source)


def machines():
    """Names of the shipped machines.

    Returns
    -------
    list of str
    """
    return _core.shipped_machines()


def setup(source):
    """How part and tools sit in the machine.

    Parameters
    ----------
    source : str, os.PathLike or dict
        A setup file, or the keys of one: `{'workpiece': {'origin': ['0 mm', '0 mm', '50 mm']}, 'tool': {'kind': 'ball',
        'diameter': '10 mm', 'length': '100 mm'}}`.

    Returns
    -------
    Setup

    Raises
    ------
    Error
        FILE0101 to FILE0115, BASE0001 to BASE0004 with the line.
    """
    if isinstance(source, _Mapping):
        return _core.read_setup_text(_text_of(source), 'setup')
    return _core.read_setup_file(source)


def controller(source):
    """A model of an existing control.

    Parameters
    ----------
    source : str, os.PathLike or dict
        The name of a shipped one (`controllers()`), a controller file, or the keys of one.

    Returns
    -------
    Controller

    Raises
    ------
    Error
        FILE0101 to FILE0118, BASE0001 to BASE0004 with the line.
    """
    if isinstance(source, _Mapping):
        return _core.read_controller_text(_text_of(source), 'controller')
    return _core.find_controller(source)


def controllers():
    """Names of the shipped controllers.

    Returns
    -------
    list of str
    """
    return _core.shipped_controllers()


__all__ = ['BsplineCurve', 'BsplineSurface', 'Controller', 'Diagnostic', 'DualCorner', 'DualPath', 'DualSpline',
           'Error', 'Face', 'FaceList', 'FeedProfile', 'FlankTool', 'GuidedSurface', 'GuidingSurface', 'Kinematics',
           'LivePlanner', 'Machine', 'OrientationSurface', 'ParameterLink', 'PartBody', 'Plan', 'Prediction',
           'Program', 'Setup', 'Stretch', 'SurfacePlan', 'Tool', 'avoid_pole', 'check', 'chord_steps',
           'compensate_deflection', 'connect', 'controller', 'controllers', 'corner_curve', 'deform_flank',
           'deform_flank_path', 'deviation_map', 'flat_interval_mm', 'machine', 'machines', 'move_surface',
           'move_surface_ahead', 'plan', 'plan_stretch', 'plan_surface', 'predict', 'program_from_poses',
           'programmed_poses', 'read_faces', 'read_program', 'read_program_text', 'reduce_rotary', 'setup',
           'singular_cones', 'smooth', 'stretches', 'two_point_poses']
