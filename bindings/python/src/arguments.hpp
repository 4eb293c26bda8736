#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "trunnion/base/quantity.hpp"

#include "errors.hpp"

/// What Python hands over, as plain values. Everything that is not what it has to be is refused by the argument's name:
/// PY0001 type or shape, PY0002 not finite, PY0003 out of range, PY0004 not one of the words.
namespace trunnion::python {

namespace py = pybind11;

using Array = py::array_t<double, py::array::c_style>;
using Shape = std::vector<py::ssize_t>;

/// Finite numbers of any shape. No copy where they are float64 in rows already.
Array numbers_of(py::handle object, const char* name);

/// An array of shape (…, width): rows of so many numbers each.
struct Rows {
    Array array;
    Shape leading;          ///< the shape without its last dimension
    py::ssize_t count = 0;  ///< of rows
    int width = 0;

    const double* row(py::ssize_t i) const { return array.data() + i * width; }
    Eigen::Vector3d vector(py::ssize_t i) const { return Eigen::Map<const Eigen::Vector3d>(row(i)); }
};
Rows rows_of(py::handle object, const char* name, int width);
/// As many rows as another argument has, in the same shape.
Rows rows_like(py::handle object, const char* name, int width, const Rows& other, const char* other_name);
/// Rows of unit vectors, brought to length 1 exactly; PY0003 where one is farther from it than 1e-6.
Rows directions_like(py::handle object, const char* name, const Rows& other, const char* other_name);

/// A new array of shape (leading…, last…).
Array array_of(const Shape& leading, std::initializer_list<py::ssize_t> last);
/// The same memory as an array that cannot be written to; `owner` is kept while it is used.
py::array view_of(const void* data, const py::dtype& type, Shape shape, Shape strides, py::handle owner);
/// Hands a vector over as an array of shape (…, columns) without copying it.
Array array_from(std::vector<double>&& values, py::ssize_t columns);

double number_of(py::handle object, const char* name);
double positive_of(py::handle object, const char* name);
int count_of(py::handle object, const char* name);
bool flag_of(py::handle object, const char* name);
std::string text_of(py::handle object, const char* name);
/// A file's name: str or os.PathLike.
std::string path_of(py::handle object, const char* name);
Eigen::Vector3d vector_of(py::handle object, const char* name);
std::vector<double> list_of(py::handle object, const char* name);
std::vector<Eigen::Vector3d> points_of(py::handle object, const char* name);
/// The items of anything that can be gone through; `wanted`: what they should be.
py::list items_of(py::handle object, const char* name, std::string_view wanted);

[[noreturn]] void refuse_type(const char* name, std::string_view wanted, py::handle given);

/// One of the module's own objects.
template <class Bound>
const Bound& object_of(py::handle object, const char* name) {
    if (py::isinstance<Bound>(object)) return object.cast<const Bound&>();
    const auto wanted = py::cast<std::string>(py::type::of<Bound>().attr("__name__"));
    refuse_type(name, "a trunnion." + wanted, object);
}

[[noreturn]] void refuse_word(const char* name, std::string_view word, const std::vector<std::string_view>& words);

/// A word and what it stands for.
template <class Value>
using Word = std::pair<std::string_view, Value>;

template <class Value, std::size_t Count>
Value word_of(py::handle object, const char* name, const Word<Value> (&words)[Count]) {
    const std::string given = text_of(object, name);
    std::vector<std::string_view> all;
    for (const auto& [word, value] : words) {
        if (word == given) return value;
        all.push_back(word);
    }
    refuse_word(name, given, all);
}

template <class Value, std::size_t Count>
std::string_view name_of(Value value, const Word<Value> (&words)[Count]) {
    for (const auto& [word, named] : words)
        if (named == value) return word;
    return {};
}

/// The keyword arguments of one call: each is taken by its name, what is left over is a TypeError. None counts as not
/// given.
class Keywords {
  public:
    Keywords(const py::kwargs& given, const char* function) : given_(given), function_(function) {}

    /// Null where it is not given.
    py::handle take(const char* name);
    /// The target stays as it is where the argument is not given; `unit`: of the argument in that of the target.
    void number(const char* name, double& target, double unit = 1);
    void number(const char* name, std::optional<double>& target, double unit = 1);
    void flag(const char* name, bool& target);
    void count(const char* name, int& target);
    void text(const char* name, std::string& target);
    template <class Value, std::size_t Count>
    void word(const char* name, Value& target, const Word<Value> (&words)[Count]) {
        if (const py::handle given = take(name)) target = word_of(given, name, words);
    }
    /// Behind the last one.
    void finish() const;

  private:
    py::dict given_;
    const char* function_;
    std::vector<std::string_view> taken_;
};

}  // namespace trunnion::python
