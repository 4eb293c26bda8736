#include "errors.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.hpp"

namespace trunnion::python {

namespace py = pybind11;

namespace {

void raise(const Diagnostic& diagnostic) {
    const py::object type = py::module_::import("trunnion._error").attr("Error");
    PyErr_SetObject(type.ptr(), type(diagnostic).ptr());
}

}  // namespace

void bind_errors(py::module_& module) {
    py::class_<Diagnostic>(module, "Diagnostic",
                           R"(What went wrong, or was noticed, for a person to act on and for a program to test.

`str()` gives it as one line. docs/diagnostics.md lists all codes.)")
        .def_readonly("code", &Diagnostic::code, "str: stable across releases: letters of the room and four digits.")
        .def_property_readonly(
            "severity", [](const Diagnostic& d) { return to_string(d.severity); }, "str: `note`, `warning` or `error`.")
        .def_readonly("text", &Diagnostic::text, "str: what is wrong.")
        .def_readonly("value", &Diagnostic::value, "str: what was found, with its unit; may be empty.")
        .def_readonly("limit", &Diagnostic::limit, "str: what would have been allowed; may be empty.")
        .def_readonly("hint", &Diagnostic::hint, "str: what to do; may be empty.")
        .def_readonly("count", &Diagnostic::count, "int: how often it was met; the place is the first.")
        .def_property_readonly(
            "file", [](const Diagnostic& d) { return d.place.file; }, "str: empty where there is none.")
        .def_property_readonly(
            "line", [](const Diagnostic& d) { return d.place.line; }, "int: from 1; 0: not known.")
        .def_property_readonly(
            "column", [](const Diagnostic& d) { return d.place.column; }, "int: from 1; 0: not known.")
        .def_property_readonly(
            "path_length_mm", [](const Diagnostic& d) { return d.place.path_length_mm; },
            "float: where on the path; NaN: not known.")
        .def("__str__", [](const Diagnostic& d) { return to_string(d); })
        .def("__repr__", [](const Diagnostic& d) { return "<trunnion.Diagnostic " + to_string(d) + ">"; });

    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            std::rethrow_exception(thrown);
        } catch (const Refusal& refusal) {
            raise(refusal.diagnostic);
        }
    });
}

}  // namespace trunnion::python
