#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/quantity.hpp"

#include "detail/apt_statement.hpp"
#include "detail/block_reader.hpp"
#include "detail/curves.hpp"
#include "detail/dialects.hpp"
#include "detail/findings.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

/// Numbers of a list, at most a pose.
struct Numbers {
    std::array<double, 12> value{};
    std::size_t count = 0;
    Eigen::Vector3d triple(std::size_t first) const { return {value[first], value[first + 1], value[first + 2]}; }
};

/// A CIRCLE or MOVARC record that waits for the GOTO that ends its arc.
struct WaitingCircle {
    Eigen::Vector3d centre_mm, normal;
    double radius_mm = 0;
    std::optional<double> sweep_rad;  ///< its ANGLE
    bool by_points = false;           ///< several GOTO may follow, all on the circle
    int points = 0;                   ///< that have followed
    double turned_rad = 0;            ///< so far, signed about the normal
};

/// A curve whose last control point has not been met.
struct WaitingCurve {
    Spot spot{};
    int degree = 3;
    std::vector<double> knots;  ///< NX: those behind the start, with the end's once
    std::vector<Eigen::Vector3d> points_mm;
    std::vector<std::int32_t> lines;  ///< of the points; NX: from the second on, as the first is where the tool is
    bool is_catia = false;            ///< BEGIN NURBS_SIEMENS … END NURBS
    bool has_second = false;          ///< CATIA, AXIS=VAR: XH YH ZH in each point
    std::vector<double> lengths, weights;
    std::vector<Eigen::Vector3d> axes;  ///< from the tip to the second curve, mm
};

/// A frame in which coordinates count: where it lies in another one.
struct PoseFrame {
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
};

/// Carries out the statements of APT data, one function each; apt.cpp has the table from words to functions,
/// apt_motion.cpp poses and feeds, apt_arc.cpp circles, apt_curve.cpp curves.
class AptReader final : public BlockReader {
  public:
    AptReader(const ProgramText& text, std::string_view file_name, const ReadOptions& options)
        : BlockReader(file_name, options, Dialect::apt), scanner_(text) {
        if (options.units == Units::inch) unit_mm_ = inch_mm;
    }

    Step read_block() override;
    bool finish() override;
    int line() const override { return scanner_.line(); }
    const ProgramText& text() const override { return scanner_.text(); }
    std::size_t position() const override { return scanner_.offset(); }
    bool waits() const override { return curve_.has_value(); }

    // The statements.
    bool go_to();
    bool from();
    bool bare_pose();
    bool rapid();
    bool feed_rate();
    bool units();
    bool multax();
    bool go_by();
    bool rotary_table();
    bool nurbs();
    bool knots();
    bool control_point();
    bool tool_axis();
    bool machine_system();
    bool part_name();
    bool load_tool();
    bool spindle();
    bool coolant() { return event(program::EventKind::coolant, false); }
    bool stop() { return event(program::EventKind::stop, true); }
    bool delay();
    bool end();
    bool remark() { return true; }
    bool ignore();
    bool only_off();
    bool circle();
    bool arc_ahead();
    bool initial_direction();
    bool go_forward();
    bool refuse_curve();
    bool refuse_motion();

  private:
    bool statement();
    bool numbers(Numbers& out, bool blanks_separate);
    bool add_pose(const Numbers& pose);
    bool set_axis(const Eigen::Vector3d& vector);
    bool add_move(const Eigen::Vector3d& position_mm, bool is_rapid, const program::Arc* arc = nullptr);
    bool wait_for_end(bool is_circle);
    bool add_on_circle(const Eigen::Vector3d& end_mm);
    bool take_angle(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm, program::Arc& arc);
    bool add_point_of_circle(const Eigen::Vector3d& end_mm);
    bool is_on_circle(const Eigen::Vector3d& point_mm) const;
    bool add_driven_arc(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& normal, double radius_mm,
                        const Eigen::Vector3d& end_mm, bool second_crossing);
    bool end_curve();
    bool begin_catia_curve();
    bool catia_line();
    bool end_catia_curve();
    bool catia_fields(std::string_view list, std::initializer_list<std::string_view> names,
                      std::vector<double>& values);
    bool add_curve(program::Curve curve, const std::vector<std::int32_t>& lines);
    /// In the program's frame, of coordinates and directions as they are written.
    Eigen::Vector3d point_mm(const Eigen::Vector3d& written) const {
        const Eigen::Vector3d mm = written * unit_mm_;
        return frame_ ? Eigen::Vector3d(frame_->axes * mm + frame_->origin_mm) : mm;
    }
    Eigen::Vector3d direction(const Eigen::Vector3d& written) const {
        return frame_ ? Eigen::Vector3d(frame_->axes * written) : written;
    }
    bool cutting_feed(program::Feed& feed);
    bool event(program::EventKind kind, bool stops, double dwell_s = 0);
    bool feed_unit(std::string_view word, double& scale);
    bool refuse(std::string_view code, std::string text, std::string_view hint = {}) {
        return findings_.refuse(code, scanner_.spot(), std::move(text), scanner_.major(), hint);
    }

    StatementScanner scanner_;
    UnitStatement stated_;
    double unit_mm_ = 1;
    std::optional<double> feed_mm_s_;
    bool feed_is_per_turn_ = false;  ///< feed_mm_s_ is mm a turn then
    std::optional<double> turns_per_s_;
    Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
    std::optional<WaitingCircle> circle_;
    std::optional<WaitingCurve> curve_;
    std::optional<PoseFrame> first_system_;     ///< of the first MSYS: the program's frame
    std::optional<PoseFrame> frame_;            ///< of the MSYS in force in the program's frame; none: the same
    std::optional<Eigen::Vector3d> direction_;  ///< of INDIRV, for the motion that follows
    std::uint16_t tool_ = 0;
    bool rapid_next_ = false, axis_held_ = false, words_seen_ = false, finished_ = false;
};

/// The next of a comma-separated list.
inline std::string_view take_item(std::string_view& list) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const std::string_view item = trimmed(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
    return item;
}

inline bool is_word(std::string_view item, std::initializer_list<std::string_view> words) {
    return std::ranges::any_of(words, [&](std::string_view word) { return reads(item, word); });
}

/// The number that an item is, all of it.
std::optional<double> number_of(std::string_view item);

}  // namespace trunnion::nc
