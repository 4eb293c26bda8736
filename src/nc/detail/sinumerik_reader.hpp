#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/curves.hpp"
#include "detail/dialects.hpp"
#include "detail/findings.hpp"
#include "detail/rs274_control.hpp"
#include "detail/sinumerik_block.hpp"
#include "detail/sinumerik_frames.hpp"
#include "detail/sinumerik_interpreter.hpp"
#include "detail/sinumerik_words.hpp"

namespace trunnion::nc::sinumerik {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
inline constexpr double default_reference_mm = 180 / std::numbers::pi;  ///< FGREF as delivered: 1 mm is 1 degree
inline constexpr std::size_t address_count = static_cast<std::size_t>(Address::count);

using RotaryWords = std::array<double, program::max_rotary_letters>;

/// The addresses of one block with their values as written.
class Addresses {
  public:
    void clear() { said_ = 0; }
    bool has(Address a) const { return (said_ & bit(a)) != 0; }
    bool has_any(Address first, Address last) const { return (said_ & (bit(last) * 2 - bit(first))) != 0; }
    void put(Address a, const Word& word) {
        said_ |= bit(a);
        value_[index(a)] = word.value;
        counting_[index(a)] = word.counting;
        column_[index(a)] = word.column;
    }
    double operator[](Address a) const { return value_[index(a)]; }
    double get(Address a, double otherwise) const { return has(a) ? value_[index(a)] : otherwise; }
    Counting counting(Address a) const { return counting_[index(a)]; }
    int column(Address a) const { return column_[index(a)]; }
    /// Marks that the address has been made use of.
    void use(Address a) { used_ |= bit(a); }
    void use(Address first, Address last) { used_ |= bit(last) * 2 - bit(first); }
    /// An address without use in its block.
    std::optional<Address> left_over() const {
        const std::uint32_t rest = said_ & ~used_;
        if (rest == 0) return {};
        return static_cast<Address>(std::countr_zero(rest));
    }
    void forget_uses() { used_ = 0; }

  private:
    static constexpr std::size_t index(Address a) { return static_cast<std::size_t>(a); }
    static constexpr std::uint32_t bit(Address a) { return 1u << index(a); }

    std::array<double, address_count> value_;
    std::array<Counting, address_count> counting_;
    std::array<int, address_count> column_;
    std::uint32_t said_ = 0, used_ = 0;
};

/// The words that stay in force from block to block.
struct Modes {
    Meaning motion = Meaning::unknown;
    Meaning feed_kind = Meaning::per_minute;
    int normal_axis = 2;  ///< across the plane of G17, G18, G19
    bool absolute = true, exact_stop = false;
    bool transform = false;     ///< TRAORI
    bool axes_linear = false;   ///< ORIAXES
    bool second_curve = false;  ///< ORICURVE
    bool in_machine = false;    ///< ORIMKS
    std::optional<Meaning> angles;
    double unit_mm = 1, feed_unit_mm = 1;
    double feed = 0;  ///< mm/min, 1/min or mm per turn; 0: none
    double spindle_rpm = unknown;
    int spline_degree = 3;  ///< SD
    std::uint16_t offset = 0;
    bool rotary_in_feed = false;  ///< FGROUP names rotary axes
    std::array<double, program::max_rotary_letters> reference_mm{default_reference_mm, default_reference_mm,
                                                                 default_reference_mm};
};

/// The tool that is in use, the one that comes next, and the cutting edge.
struct ToolInUse {
    std::string name;
    std::optional<std::string> prepared;
    int prepared_edge = 1;              ///< D in the block of T
    std::optional<bool> changed_by_m6;  ///< else T itself changes; empty: not looked for yet
    std::uint16_t index = 0;            ///< in Program::tools: whose length counts
    std::uint16_t in_spindle = 0;       ///< in Program::tools: what hangs in the spindle, D0 or not
};

/// In what the linear words count; positions of machine axes depend on neither offset nor tool, which are 0 then.
struct CountedIn {
    program::Space space = program::Space::untransformed;
    std::uint16_t offset = 0, tool = 0;
    bool operator==(const CountedIn&) const = default;
};

/// How to get to a place.
struct Way {
    bool rapid = false;
    std::optional<double> speed_mm_s;   ///< of a cycle; empty: the feed in force
    std::optional<program::Arc> arc{};  ///< in the work offset's frame
    bool curved = false;                ///< along a curve: a block of BSPLINE, or the one of POLY in `curve`
    std::optional<program::Curve> curve{};
};

/// A control point of BSPLINE in the work offset's frame, and what its block says besides.
struct SplinePoint {
    Eigen::Vector3d position_mm;
    Eigen::Vector3d axis;  ///< of the tool, not unit with a second curve; unknown: not known, or law rotary
    RotaryWords rotary_rad{};
    double weight = 1;        ///< PW
    double length = unknown;  ///< PL; unknown: not said
    double second_mm = 0;     ///< from here to the point of the second curve; 0: none, unknown: not known
    program::Feed feed{};     ///< of the block
    std::size_t events = 0;   ///< that were there when its motion began
    std::int32_t line = 0;
    bool exact_stop = false;
};

/// A B-spline whose end has not been met.
struct SplineInWork {
    CountedIn counted_in;
    int degree = 3;
    program::OrientationLaw law = program::OrientationLaw::rotary;
    std::uint16_t tool = 0;
    Spot place;                       ///< of its first block
    std::vector<SplinePoint> points;  ///< the first one is where the tool stands before it
};

/// A block of POLY: coefficients by X Y Z, XH YH ZH and the machine's rotary axes, of p⁰, p¹ … in mm and rad.
struct PolynomialBlock {
    static constexpr std::size_t second = 3, rotary = 6, axes = 9;
    std::array<std::vector<double>, axes> numerators;
    std::vector<double> denominator{1};
    double length = 1;  ///< PL
    std::size_t degree = 1;
};

/// Carries out the blocks that the interpreter hands over. sinumerik_reader.cpp: words, modes, tools;
/// sinumerik_motion.cpp: where a block goes, how fast, and which poses are kept; sinumerik_curves.cpp: BSPLINE and
/// ORICURVE; sinumerik_polynomials.cpp: POLY; sinumerik_orientation.cpp: rotary words, vectors, frames, CYCLE800;
/// sinumerik_cycles.cpp: drilling.
class SinumerikReader final : public BlockReader {
  public:
    SinumerikReader(const ProgramText& text, std::string_view file_name, const ReadOptions& options, Control control);

    Step read_block() override;
    bool finish() override;
    int line() const override { return block_.line; }
    const ProgramText& text() const override { return interpreter_.text(); }
    std::size_t position() const override { return interpreter_.position(); }
    bool waits() const override { return spline_.has_value(); }
    char rotary_letter(std::size_t axis) const override { return control_.rotary_letter(axis); }
    bool is_said(std::size_t axis) const override { return (rotary_ever_ & (1u << axis)) != 0; }

  private:
    // words
    bool block();
    bool take(const Word& word);
    bool letter(char c, const Word& word);
    bool axis_letter(char c, const Word& word);
    bool name(const Word& word);
    bool put(Address address, const Word& word);
    bool once(const Word*& kept, const Word& word);
    bool g_word(const Word& word);
    bool m_word(const Word& word);
    bool own_word(char letter, int number);
    bool enter_group(Group group, Meaning meaning, const Word& word);
    bool mode(const WordRule& rule, const Word& word);
    bool orientation_mode(Meaning meaning, const Word& word);
    void set_transform(bool on);
    bool not_supported(Meaning meaning, const Word& word);
    bool smoothing_cycle(const Word& word);
    bool select_offset(const Word& word);
    bool tool_words();
    bool select_tool(const Word& word);
    bool is_changed_by_m6();
    bool use_tool(int edge, const Word& word);
    bool feed_group(const Word& word);
    bool feed_reference(const Word& word);
    bool spindle_speed(const Word& word);
    bool feed_word();
    bool carry_out();
    bool dwell();
    bool check_use();
    bool finish_block();

    // motion
    bool motion();
    bool asks_motion() const;
    bool count_in(bool suppressed);
    bool linear_word(Address address, Eigen::Vector3d& to);
    bool circle(Eigen::Vector3d& to, Way& way);
    bool circle_in_plane(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Way& way);
    bool circle_through(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Way& way);
    bool tangential_circle(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Way& way);
    bool keep_circle(const Result<program::Arc>& arc, Way& way);
    Eigen::Vector3d centre(const Eigen::Vector3d& from);
    bool goes_by_angle() const;
    bool turn_to_angle(const Eigen::Vector3d& from, Eigen::Vector3d& to);
    double radius_of_angle(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
    Eigen::Vector3d last_direction() const;
    bool go(const Eigen::Vector3d& to, const Way& way);
    bool leave_out(const Way& way);
    bool feed_of(program::Move& move, const Way& way);
    bool feed_of_rotation(program::Move& move, double speed_mm_s);
    bool feed_of_group(program::Move& move, const Way& way, double speed_mm_s);
    bool path_speed(double& speed_mm_s);
    bool add(program::Move& move);
    Spot spot_of_motion() const;
    bool never_started();
    void tell_assumptions();

    // curves
    bool polynomial_word(const Word& word);
    bool curve_axes(const Word& word);
    bool add_spline_point(const Eigen::Vector3d& to);
    bool begin_spline();
    bool spline_degree();
    bool spline_words(SplinePoint& point);
    bool complete_lengths(SplineInWork& work);
    bool end_spline();
    bool add_spline(const SplineInWork& work, std::size_t first, const std::vector<std::size_t>& blocks,
                    program::Curve curve);
    bool spline_orientation(const SplineInWork& work, program::Curve& curve);
    bool refuse_in(const SplineInWork& work, std::string_view code, std::string text, std::string_view hint = {}) {
        return findings_.refuse(code, work.place, std::move(text), {}, hint);
    }
    bool go_along_polynomial(const Eigen::Vector3d& to);
    bool coefficients(const Eigen::Vector3d& to, PolynomialBlock& block);
    bool second_coefficients(PolynomialBlock& block);
    std::optional<std::size_t> numerator_of(std::string_view axis) const;
    bool keep_coefficients(const Word& word, PolynomialBlock& block);
    bool denominator(const Word& word, PolynomialBlock& block);
    bool curve_of(const PolynomialBlock& block, program::Curve& curve);
    bool second_point(const Eigen::Vector3d& to);

    // orientation and frames
    bool rotary_word(Address address);
    bool has_free_rotary(const RotaryWords& words) const;
    bool orientation();
    bool vector_words(Eigen::Vector3d& vector);
    bool angle_words(Eigen::Vector3d& vector);
    bool frame_statement();
    bool frame_values(double otherwise, double unit, Eigen::Vector3d& values);
    bool rotation(CoordinateFrame& turned);
    bool swivel(const Word& call);
    bool swivel_frame(const Word& call, CoordinateFrame& frame);
    void leave_plane();
    void frames_changed();
    CoordinateFrame frame_in_force() const { return swivel_frame_.with(programmable_); }

    // drilling
    bool call(const Word& word);
    bool modal_call();
    bool run_cycle(const Word& cycle);
    bool pattern(const Word& word);

    friend class DrillingCycle;

    /// True, so that the word is done with it.
    bool event(program::EventKind kind, bool stops, std::string word, double dwell_s = 0) {
        program_.events.push_back({kind, stops, dwell_s, std::move(word), program_.moves.size(), block_.line});
        return true;
    }
    bool refuse(std::string_view code, const Spot& spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, spot, std::move(text), value, hint);
    }
    bool refuse(std::string_view code, const Word& word, std::string text, std::string_view hint = {});
    Spot spot(Address address) const { return {block_.place.line, said_.column(address), block_.place.file}; }

    Interpreter interpreter_;
    Control control_;
    Block block_;
    Modes modes_;
    UnitStatement stated_;
    ToolInUse tool_;

    // of the block
    Addresses said_;
    std::array<Meaning, static_cast<std::size_t>(Group::count)> groups_{};
    const Word* frame_word_ = nullptr;  ///< TRANS, ROT, …
    const Word* call_ = nullptr;        ///< a cycle, a pattern, CYCLE800
    const Word* modal_call_ = nullptr;  ///< MCALL
    const Word* stop_ = nullptr;
    const Word *tool_word_ = nullptr, *edge_word_ = nullptr, *change_word_ = nullptr;  ///< T, D, M6
    std::vector<const Word*> polynomials_;                                             ///< PO
    Eigen::Vector3d second_from_mm_;  ///< the second curve before this block
    RotaryWords rotary_from_rad_{};   ///< the rotary words before it
    bool exact_stop_once_ = false;

    // where things stand
    CountedIn counted_in_;
    CoordinateFrame programmable_, swivel_frame_;
    CoordinateFrame frame_;                        ///< that counted_in_ counts in
    Eigen::Vector3d position_mm_, programmed_mm_;  ///< in the offset's frame and in frame_; unknown: stays
    RotaryWords rotary_rad_;                       ///< by the machine's rotary axes; unknown: as they stand
    std::uint32_t rotary_ever_ = 0;                ///< bit of each rotary axis with a word
    program::OrientationLaw law_ = program::OrientationLaw::rotary;
    Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();  ///< of law vector, in the offset's frame
    Eigen::Vector3d second_mm_;  ///< the point of ORICURVE's second curve, in the offset's frame; unknown: any
    std::optional<SplineInWork> spline_;
    bool swivelled_ = false;
    bool tool_as_swivelled_ = false;  ///< no orientation was programmed since CYCLE800
    bool whole_pose_needed_ = false;  ///< X, Y and Z must be known before anything moves: the tool was swivelled
    bool rapid_left_out_ = false;     ///< the programmed place was not gone to: something of it was not known
    std::optional<Word> modal_cycle_;
    std::string modal_cycle_name_;  ///< that its name points to
    bool axis_words_ever_ = false, exact_stop_said_ = false, finished_ = false;
    Spot last_motion_;
};

}  // namespace trunnion::nc::sinumerik
