#include "arguments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace trunnion::python {

void refuse_type(const char* name, std::string_view wanted, py::handle given) {
    refuse({.code = "PY0001",
            .text = fmt::format("{}: {} wanted", name, wanted),
            .value = py::cast<std::string>(py::str(py::type::handle_of(given).attr("__name__")))});
}

namespace {

std::string shape_text(const py::array& array) {
    std::string out = "(";
    for (py::ssize_t i = 0; i < array.ndim(); ++i) out += fmt::format("{}{}", i > 0 ? ", " : "", array.shape(i));
    return out + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void refuse_shape(const char* name, const std::string& wanted, const py::array& given) {
    refuse({.code = "PY0001", .text = fmt::format("{}: shape {} wanted", name, wanted), .value = shape_text(given)});
}

[[noreturn]] void refuse_infinite(const char* name, double value) {
    refuse({.code = "PY0002", .text = fmt::format("{}: not a finite number", name), .value = fmt::format("{}", value)});
}

}  // namespace

Array numbers_of(py::handle object, const char* name) {
    const py::array given = py::array::ensure(object);
    if (!given) refuse_type(name, "numbers", object);
    const char kind = given.dtype().kind();
    if (kind != 'f' && kind != 'i' && kind != 'u')
        refuse({.code = "PY0001",
                .text = fmt::format("{}: numbers wanted", name),
                .value = "dtype " + py::cast<std::string>(py::str(given.dtype()))});
    Array out = py::array_t < double, py::array::c_style | py::array::forcecast > ::ensure(given);
    if (!out) refuse_type(name, "numbers", object);
    const double* end = out.data() + out.size();
    const double* odd = std::find_if_not(out.data(), end, [](double value) { return std::isfinite(value); });
    if (odd != end) refuse_infinite(name, *odd);
    return out;
}

Rows rows_of(py::handle object, const char* name, int width) {
    Rows out{.array = numbers_of(object, name), .leading = {}, .width = width};
    const py::ssize_t dimensions = out.array.ndim();
    if (dimensions == 0 || out.array.shape(dimensions - 1) != width)
        refuse_shape(name, fmt::format("(…, {})", width), out.array);
    out.leading.assign(out.array.shape(), out.array.shape() + dimensions - 1);
    out.count = out.array.size() / width;
    return out;
}

Rows rows_like(py::handle object, const char* name, int width, const Rows& other, const char* other_name) {
    Rows out = rows_of(object, name, width);
    if (out.leading != other.leading)
        refuse_shape(name,
                     fmt::format("as many rows as {}, ({}{}{}),", other_name, fmt::join(other.leading, ", "),
                                 other.leading.empty() ? "" : ", ", width),
                     out.array);
    return out;
}

Rows directions_like(py::handle object, const char* name, const Rows& other, const char* other_name) {
    constexpr double nearly = 1e-6;
    const Rows given = rows_like(object, name, 3, other, other_name);
    Rows out{.array = array_of(given.leading, {3}), .leading = given.leading, .count = given.count, .width = 3};
    for (py::ssize_t i = 0; i < given.count; ++i) {
        const double length = given.vector(i).norm();
        if (std::abs(length - 1) > nearly)
            refuse({.code = "PY0003",
                    .text = fmt::format("{}: row {} is not a unit vector", name, i),
                    .value = fmt::format("length {}", length),
                    .hint = "divide each vector by its length"});
        Eigen::Map<Eigen::Vector3d>(out.array.mutable_data() + 3 * i) = given.vector(i) / length;
    }
    return out;
}

Array array_of(const Shape& leading, std::initializer_list<py::ssize_t> last) {
    Shape shape = leading;
    shape.insert(shape.end(), last);
    return Array(shape);
}

py::array view_of(const void* data, const py::dtype& type, Shape shape, Shape strides, py::handle owner) {
    py::array out(type, std::move(shape), std::move(strides), data, owner);
    py::detail::array_proxy(out.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
    return out;
}

Array array_from(std::vector<double>&& values, py::ssize_t columns) {
    auto kept = std::make_unique<std::vector<double>>(std::move(values));
    const auto rows = static_cast<py::ssize_t>(kept->size()) / columns;
    double* data = kept->data();
    const py::capsule owner(kept.get(), [](void* vector) { delete static_cast<std::vector<double>*>(vector); });
    kept.release();
    return Array({rows, columns}, data, owner);
}

double number_of(py::handle object, const char* name) {
    const double value = PyFloat_AsDouble(object.ptr());
    if (value == -1 && PyErr_Occurred()) {
        PyErr_Clear();
        refuse_type(name, "a number", object);
    }
    if (!std::isfinite(value)) refuse_infinite(name, value);
    return value;
}

double positive_of(py::handle object, const char* name) {
    const double value = number_of(object, name);
    if (value > 0) return value;
    refuse({.code = "PY0003",
            .text = fmt::format("{}: out of range", name),
            .value = fmt::format("{}", value),
            .limit = "above 0"});
}

int count_of(py::handle object, const char* name) {
    const py::object index = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
    PyErr_Clear();
    if (!index || PyBool_Check(object.ptr())) refuse_type(name, "a whole number", object);
    int overflow = 0;
    const long value = PyLong_AsLongAndOverflow(index.ptr(), &overflow);
    if (overflow != 0 || value > std::numeric_limits<int>::max() || value < std::numeric_limits<int>::min())
        refuse({.code = "PY0003",
                .text = fmt::format("{}: out of range", name),
                .value = py::cast<std::string>(py::str(index))});
    return static_cast<int>(value);
}

bool flag_of(py::handle object, const char* name) {
    if (PyBool_Check(object.ptr())) return object.ptr() == Py_True;
    if (!py::isinstance(object, py::dtype::of<bool>().attr("type"))) refuse_type(name, "True or False", object);
    return PyObject_IsTrue(object.ptr()) == 1;
}

std::string text_of(py::handle object, const char* name) {
    if (!PyUnicode_Check(object.ptr())) refuse_type(name, "text", object);
    Py_ssize_t size = 0;
    const char* text = PyUnicode_AsUTF8AndSize(object.ptr(), &size);
    if (text) return {text, static_cast<std::size_t>(size)};
    PyErr_Clear();  // half a surrogate pair
    refuse_type(name, "text in UTF-8", object);
}

std::string path_of(py::handle object, const char* name) {
    const py::object path = py::reinterpret_steal<py::object>(PyOS_FSPath(object.ptr()));
    PyErr_Clear();
    if (!path || !PyUnicode_Check(path.ptr())) refuse_type(name, "a file's name", object);
    std::string out = text_of(path, name);
    if (out.find('\0') != std::string::npos)
        refuse({.code = "PY0003", .text = fmt::format("{}: a file's name has no zeros in it", name)});
    return out;
}

Eigen::Vector3d vector_of(py::handle object, const char* name) {
    const Rows rows = rows_of(object, name, 3);
    if (rows.array.ndim() != 1) refuse_shape(name, "(3,)", rows.array);
    return rows.vector(0);
}

std::vector<double> list_of(py::handle object, const char* name) {
    const Array array = numbers_of(object, name);
    if (array.ndim() != 1) refuse_shape(name, "(n,)", array);
    return {array.data(), array.data() + array.size()};
}

std::vector<Eigen::Vector3d> points_of(py::handle object, const char* name) {
    const Rows rows = rows_of(object, name, 3);
    if (rows.array.ndim() != 2) refuse_shape(name, "(n, 3)", rows.array);
    std::vector<Eigen::Vector3d> out(static_cast<std::size_t>(rows.count));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = rows.vector(static_cast<py::ssize_t>(i));
    return out;
}

py::list items_of(py::handle object, const char* name, std::string_view wanted) {
    const auto items = py::reinterpret_steal<py::object>(PySequence_List(object.ptr()));
    if (items) return items;
    PyErr_Clear();
    refuse_type(name, wanted, object);
}

void refuse_word(const char* name, std::string_view word, const std::vector<std::string_view>& words) {
    refuse({.code = "PY0004",
            .text = fmt::format("{}: unknown word", name),
            .value = std::string(word),
            .hint = fmt::format("one of {}", fmt::join(words, ", "))});
}

py::handle Keywords::take(const char* name) {
    taken_.emplace_back(name);
    const py::handle value = PyDict_GetItemString(given_.ptr(), name);
    return value && !value.is_none() ? value : py::handle();
}

void Keywords::number(const char* name, double& target, double unit) {
    if (const py::handle given = take(name)) target = number_of(given, name) * unit;
}

void Keywords::number(const char* name, std::optional<double>& target, double unit) {
    if (const py::handle given = take(name)) target = number_of(given, name) * unit;
}

void Keywords::flag(const char* name, bool& target) {
    if (const py::handle given = take(name)) target = flag_of(given, name);
}

void Keywords::count(const char* name, int& target) {
    if (const py::handle given = take(name)) target = count_of(given, name);
}

void Keywords::text(const char* name, std::string& target) {
    if (const py::handle given = take(name)) target = text_of(given, name);
}

void Keywords::finish() const {
    for (const auto& [key, value] : given_) {
        const std::string name = py::cast<std::string>(key);
        if (std::ranges::find(taken_, name) == taken_.end())
            throw py::type_error(fmt::format("{}() got an unexpected keyword argument '{}'", function_, name));
    }
}

}  // namespace trunnion::python
