#pragma once

#include <array>

#include "trunnion/numeric/taylor3.hpp"

#include "arguments.hpp"

/// Vectors and series from and into the rows of arrays.
namespace trunnion::python {

/// Writes three numbers and gives where the next ones go.
inline double* put(double* out, const Eigen::Vector3d& vector) {
    for (int i = 0; i < 3; ++i) out[i] = vector[i];
    return out + 3;
}

inline double derivative(const Taylor3& series, int order) {
    constexpr std::array<double, 4> factorial{1, 1, 2, 6};
    return series.c[static_cast<std::size_t>(order)] * factorial[static_cast<std::size_t>(order)];
}

/// Value and three derivatives, each a row of all coordinates.
template <std::size_t Size>
double* put_derivatives(double* out, const std::array<Taylor3, Size>& series) {
    for (int order = 0; order < 4; ++order)
        for (const Taylor3& coordinate : series) *out++ = derivative(coordinate, order);
    return out;
}

/// The reverse, from rows `width` apart.
inline Taylor3 series_from(const double* column, int width) {
    return {column[0], column[width], column[2 * width] / 2, column[3 * width] / 6};
}

/// An array of shape (at.shape…, last…), filled number by number: fill(number, where its results go).
template <class Fill>
Array at_each(const Array& at, std::initializer_list<py::ssize_t> last, Fill&& fill) {
    Array out = array_of(Shape(at.shape(), at.shape() + at.ndim()), last);
    const py::ssize_t size = at.size() == 0 ? 0 : out.size() / at.size();
    for (py::ssize_t i = 0; i < at.size(); ++i) fill(at.data()[i], out.mutable_data() + i * size);
    return out;
}

inline py::array view_of_numbers(const std::vector<double>& numbers, py::handle owner) {
    return view_of(numbers.data(), py::dtype::of<double>(), {static_cast<py::ssize_t>(numbers.size())},
                   {static_cast<py::ssize_t>(sizeof(double))}, owner);
}

inline py::array view_of_points(const std::vector<Eigen::Vector3d>& points, py::handle owner) {
    return view_of(points.data(), py::dtype::of<double>(), {static_cast<py::ssize_t>(points.size()), 3},
                   {static_cast<py::ssize_t>(sizeof(Eigen::Vector3d)), static_cast<py::ssize_t>(sizeof(double))},
                   owner);
}

}  // namespace trunnion::python
