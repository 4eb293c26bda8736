#pragma once

#include <filesystem>
#include <vector>

#include <pybind11/pybind11.h>

/// One function for each topic of the module; module.cpp calls them in this order, since a class has to be known before
/// it is used as a base or as a default.
namespace trunnion::python {

void bind_errors(pybind11::module_& module);
void bind_geometry(pybind11::module_& module);
void bind_surfaces(pybind11::module_& module);
void bind_machine(pybind11::module_& module);
void bind_program(pybind11::module_& module);
void bind_plan(pybind11::module_& module);
void bind_stretches(pybind11::module_& module);
void bind_speed(pybind11::module_& module);
void bind_check(pybind11::module_& module);
void bind_predict(pybind11::module_& module);
void bind_reshape(pybind11::module_& module);
void bind_links(pybind11::module_& module);
void bind_corners(pybind11::module_& module);
void bind_deformation(pybind11::module_& module);
void bind_faces(pybind11::module_& module);
void bind_surfacing(pybind11::module_& module);
void bind_surface_motion(pybind11::module_& module);
void bind_orientation(pybind11::module_& module);

/// Where the shipped machines or controllers are, best first: beside the installed package, where it was installed to,
/// in the sources.
std::vector<std::filesystem::path> data_folders(const char* kind);

}  // namespace trunnion::python
