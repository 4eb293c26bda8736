#include <string>

#include <pybind11/pybind11.h>

#include "bindings.hpp"

namespace trunnion::python {

std::vector<std::filesystem::path> data_folders(const char* kind) {
    const auto package = pybind11::cast<std::string>(pybind11::module_::import("trunnion").attr("__file__"));
    const std::filesystem::path installed(TRUNNION_INSTALL_DATA_DIR), sources(TRUNNION_SOURCE_DATA_DIR);
    return {std::filesystem::path(package).parent_path() / TRUNNION_DATA_FROM_PACKAGE / kind, installed / kind,
            sources / kind};
}

}  // namespace trunnion::python

PYBIND11_MODULE(_core, module) {
    using namespace trunnion::python;
    pybind11::options options;
    options.disable_function_signatures();  // every docstring begins with its own
    bind_errors(module);
    bind_geometry(module);
    bind_surfaces(module);
    bind_machine(module);
    bind_program(module);
    bind_plan(module);
    bind_stretches(module);
    bind_speed(module);
    bind_check(module);
    bind_predict(module);
    bind_reshape(module);
    bind_links(module);
    bind_corners(module);
    bind_deformation(module);
    bind_faces(module);
    bind_surfacing(module);
    bind_surface_motion(module);
    bind_orientation(module);
    module.attr("__version__") = TRUNNION_VERSION;
}
