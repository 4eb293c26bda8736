#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "detail/curves.hpp"
#include "detail/g_code_writer.hpp"

namespace trunnion::nc {

/// SINUMERIK 840D. Vectors under TRAORI and ORIVECT, rotary words under TRAORI and ORIAXES; D0 where SUPA says Z.
/// sinumerik_writer.cpp: modes, tools, straight moves and circles; sinumerik_writer_curves.cpp: BSPLINE and POLY.
class SinumerikWriter final : public GCodeWriter {
  public:
    SinumerikWriter(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                    const TextSink& sink);

  private:
    void head() override;
    void tail() override;
    bool enter(const Move& to) override;
    bool transform(bool on);
    void turn_by(std::string_view mode);
    bool count_offset(const Move& to);
    bool count_tool(const Move& to, bool in_machine);
    void words_before_motion(const Move& to) override;
    void orientation_words(const Move& to) override;
    void vector_words() override;
    void turn_words(int turns) override;
    bool arc(const Move& to) override;
    bool arc_through_point(const program::Arc& arc, const Move& to);
    void dwell(double seconds) override;
    bool prepare_tool(std::string_view name) override;
    bool change_tool(std::string_view name) override;
    void plain(std::string_view word);

    // curves
    std::size_t curve(std::size_t first) override;
    bool curve_fits(const Move& to);
    std::string_view mode_of(const Move& to) const;
    std::size_t moves_of_bspline(std::size_t first) const;
    bool fits_poly(std::size_t move) const;
    std::size_t bspline(std::size_t first, std::size_t count);
    std::size_t poly(std::size_t index);
    void control_words(const program::Curve& curve, std::size_t point, const Move& to);
    std::optional<Eigen::Vector3d> second_way(std::size_t move) const;
    void second_words(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& way_mm);
    bool second_stands_at(std::size_t first) const;
    void say_second_point(std::size_t first);
    double second_scale(std::size_t index, const program::Curve& piece);
    void polynomial(std::string_view axis, const DecimalGrid& grid, std::int64_t end, const DecimalGrid& coefficients,
                    const std::vector<double>& ordinates);
    void linear_polynomials(const program::Curve& piece);
    void denominator(const program::Curve& piece);
    void rotary_polynomials(const program::Curve& piece);
    void second_polynomials(const program::Curve& piece, double scale);

    bool changes_by_m6_;
    program::Space space_ = program::Space::untransformed;
    bool transform_ = false;
    std::string_view mode_;                                              ///< of orientation
    std::size_t second_said_ = std::numeric_limits<std::size_t>::max();  ///< the move whose end has second_mm_
    Eigen::Vector3d second_mm_ = Eigen::Vector3d::Zero();                ///< the point XH YH ZH that was said last
    std::optional<std::uint16_t> offset_;
    std::string spindle_, counted_;
    std::optional<std::string> prepared_;
};

}  // namespace trunnion::nc
