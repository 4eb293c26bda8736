#include "errors.hpp"

#include <cmath>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "arguments.hpp"
#include "bindings.hpp"

namespace trunnion::python {

namespace {

void raise(const Diagnostic& diagnostic) {
    const py::object type = py::module_::import("trunnion._error").attr("Error");
    PyErr_SetObject(type.ptr(), type(diagnostic).ptr());
}

constexpr Word<Severity> severities[]{
    {"note", Severity::note}, {"warning", Severity::warning}, {"error", Severity::error}};

/// Not known, where a place on a path is meant.
bool is_nan(py::handle object) {
    return PyFloat_Check(object.ptr()) && std::isnan(PyFloat_AS_DOUBLE(object.ptr()));
}

Diagnostic make_diagnostic(py::handle code, py::handle text, const py::kwargs& given) {
    Diagnostic out{.code = text_of(code, "code"), .text = text_of(text, "text")};
    Keywords keywords(given, "Diagnostic");
    keywords.text("value", out.value);
    keywords.text("limit", out.limit);
    keywords.text("hint", out.hint);
    keywords.word("severity", out.severity, severities);
    keywords.count("count", out.count);
    keywords.text("file", out.place.file);
    keywords.count("line", out.place.line);
    keywords.count("column", out.place.column);
    if (const py::handle where = keywords.take("path_length_mm"); where && !is_nan(where))
        out.place.path_length_mm = number_of(where, "path_length_mm");
    keywords.finish();
    return out;
}

/// What make_diagnostic() takes to make the same one again.
py::tuple parts_of(const Diagnostic& d) {
    py::dict options;
    options["value"] = d.value;
    options["limit"] = d.limit;
    options["hint"] = d.hint;
    options["severity"] = to_string(d.severity);
    options["count"] = d.count;
    options["file"] = d.place.file;
    options["line"] = d.place.line;
    options["column"] = d.place.column;
    options["path_length_mm"] = d.place.path_length_mm;
    return py::make_tuple(d.code, d.text, options);
}

Diagnostic from_parts(const py::tuple& parts) {
    return make_diagnostic(parts[0], parts[1], py::reinterpret_borrow<py::kwargs>(parts[2]));
}

constexpr const char* diagnostic_doc = R"(Diagnostic(code, text, **fields)
--

What went wrong, or was noticed, for a person to act on and for a program to test. `str()` gives it as one line;
docs/diagnostics.md lists all codes. The library makes them; one of your own may travel in an `Error`. Can be pickled.

Parameters
----------
code, text : str
value, limit, hint, file : str
    Empty.
severity : {'error', 'warning', 'note'}
count, line, column : int
    1; 0: not known.
path_length_mm : float
    NaN: not known.

Raises
------
Error
    PY0001 to PY0004 by the argument's name.)";

}  // namespace

void bind_errors(py::module_& module) {
    py::class_<Diagnostic>(module, "Diagnostic", diagnostic_doc)
        .def(py::init(&make_diagnostic), py::arg("code"), py::arg("text"))
        .def(py::pickle(&parts_of, &from_parts))
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
