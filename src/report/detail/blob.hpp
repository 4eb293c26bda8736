#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace trunnion::report::detail {

/// Columns of numbers one behind the other, each beginning at a multiple of 8 bytes, little endian. In the page they
/// stand as deflated bytes in base64.
class Blob {
  public:
    struct Place {
        std::size_t offset = 0, count = 0;
        const char* type = "";  ///< `f32`, `f64`, `i32`, `i16`, `u8`
    };

    template <class Number>
    Place add(std::span<const Number> numbers) {
        bytes_.resize((bytes_.size() + 7) / 8 * 8);
        const Place place{bytes_.size(), numbers.size(), type_name<Number>()};
        const auto* first = reinterpret_cast<const char*>(numbers.data());
        bytes_.append(first, numbers.size_bytes());
        return place;
    }

    std::size_t size() const { return bytes_.size(); }
    /// Raw deflate.
    std::string deflated() const;

  private:
    template <class Number>
    static constexpr const char* type_name() {
        if constexpr (std::is_same_v<Number, float>) return "f32";
        if constexpr (std::is_same_v<Number, double>) return "f64";
        if constexpr (std::is_same_v<Number, std::int32_t>) return "i32";
        if constexpr (std::is_same_v<Number, std::int16_t>) return "i16";
        return "u8";
    }

    std::string bytes_;
};

/// With padding, without line breaks.
std::string base64(std::string_view bytes);

}  // namespace trunnion::report::detail
