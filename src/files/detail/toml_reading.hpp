#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <toml++/toml.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/base/result.hpp"

namespace trunnion::files::detail {

/// Errors: FILE0101.
Result<std::string> read_text(const std::filesystem::path& path);

/// Errors: FILE0102, with line and column.
Result<toml::table> parse_toml(std::string_view text, std::string_view file_name);

/// Takes values out of one TOML file. The first thing that is wrong is kept, with its place; from then on every
/// question answers with a default, so that the code that reads a file says what is in it and no more.
class TomlReading {
  public:
    explicit TomlReading(std::string_view file_name) : file_name_(file_name) {}

    bool ok() const { return !error_; }
    const Diagnostic& error() const { return *error_; }
    void refuse(std::string code, std::string text, const toml::node& where, std::string hint = {});
    /// Keeps a diagnostic from elsewhere, placed here.
    void refuse(Diagnostic diagnostic, const toml::source_region& where);

    /// FILE0104 for the first key of the table that is not among those.
    void allow_only(const toml::table& table, std::string_view what, std::initializer_list<std::string_view> keys);
    /// The value of a key, or FILE0103 at the table.
    const toml::node* required(const toml::table& table, std::string_view key, std::string_view what);

    const toml::table& table(const toml::node& node, std::string_view what);
    std::string text(const toml::node& node, std::string_view what);
    bool flag(const toml::node& node, std::string_view what);
    std::vector<std::string> texts(const toml::node& node, std::string_view what);
    /// One of several words, as its index; FILE0113 otherwise.
    int choice(const toml::node& node, std::string_view what, std::initializer_list<std::string_view> words);

    double quantity(const toml::node& node, Dimension wanted, std::string_view what);
    std::vector<double> quantities(const toml::node& node, std::size_t count, Dimension wanted, std::string_view what);
    Eigen::Vector3d lengths_mm(const toml::node& node, std::string_view what);
    /// Three plain numbers, made a unit vector; FILE0109 when they are all 0.
    Eigen::Vector3d direction(const toml::node& node, std::string_view what);

  private:
    const toml::array* array_of(const toml::node& node, std::size_t count, std::string_view what);

    std::string file_name_;
    std::optional<Diagnostic> error_;
};

}  // namespace trunnion::files::detail
