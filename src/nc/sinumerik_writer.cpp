#include "detail/sinumerik_writer.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Move;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr double reference_mm = 1 / degree;  ///< FGREF as delivered

bool says_m6(const program::Program& program) {
    return std::ranges::any_of(program.events, [](const program::Event& event) {
        const auto actions = actions_of(event);
        return actions.front().kind == Action::Kind::change_tool && !event.word.starts_with('T');
    });
}

bool knows_offset(std::string_view word) {
    if (word.size() == 3) return word >= "G54" && word <= "G57";
    return word == "G500" || (word.size() == 4 && word >= "G505" && word <= "G599");
}

std::string call_of(std::string_view name) {
    const bool number = name.find_first_not_of("0123456789") == name.npos;
    return number ? fmt::format("T{}", name) : fmt::format("T=\"{}\"", name);
}

}  // namespace

SinumerikWriter::SinumerikWriter(const program::Program& program, const machine::Machine* machine,
                                 const WriteOptions& options, const TextSink& sink)
    : GCodeWriter(program, machine, options, sink,
                  Habits{.comment_begin = ';', .comment_end = 0, .turn_mm = reference_mm, .arcs = sinumerik_arcs}),
      changes_by_m6_(says_m6(program)) {}

void SinumerikWriter::head() {
    head_comments();
    if (!program_.curves.empty() && options_.curves != CurveForm::poly && options_.curves != CurveForm::points)
        comment("BSPLINE: both ends are taken to be knots of full multiplicity; PL=0 stands beside them");
    line(options_.units == Units::inch ? "G17 G40 G700 G90 G94 G64" : "G17 G40 G710 G90 G94 G64");
}

void SinumerikWriter::tail() {
    if (!ends_itself()) line("M30");
}

bool SinumerikWriter::enter(const Move& to) {
    const bool in_machine = to.space == Space::machine;
    if (!count_tool(to, in_machine)) return false;
    if (to.space != space_) {
        forget_linear();
        forget_axis();
        space_ = to.space;
    }
    if (in_machine) return transform(false) && curve_fits(to);
    if (!count_offset(to) || !transform(to.space == Space::workpiece)) return false;
    if (to.space == Space::workpiece) turn_by(mode_of(to));
    return curve_fits(to);
}

bool SinumerikWriter::transform(bool on) {
    if (transform_ == on) return true;
    if (transform_ || on) line(on ? "TRAORI" : "TRAFOOF");
    transform_ = on;
    forget_linear();
    forget_axis();
    return true;
}

void SinumerikWriter::turn_by(std::string_view mode) {
    if (mode_ == mode) return;
    line(mode);
    mode_ = mode;
    forget_axis();
}

bool SinumerikWriter::count_offset(const Move& to) {
    if (to.offset == offset_) return true;
    const std::string& name = offset_name(to);
    const std::string word = name.empty() ? "G500" : name;
    if (!knows_offset(word))
        return refuse("NC0905", "no such work offset in this dialect", name, "G54 … G57, G505 … G599 are there");
    if (offset_ || word != "G500") line(word);
    offset_ = to.offset;
    forget_linear();
    forget_axis();
    return true;
}

/// The cutting edge whose length counts. SUPA counts Z with the tool's length unless D0 is said.
bool SinumerikWriter::count_tool(const Move& to, bool in_machine) {
    const bool counts_nothing = in_machine && !std::isnan(to.position_mm.z());
    const std::string& name = tool_name(to);
    const std::string wanted = counts_nothing ? spindle_ + " D0" : name;
    if (in_machine && !counts_nothing) return true;
    if (wanted == counted_) return true;
    std::string_view edge = "D1";
    if (wanted != spindle_) {
        const std::size_t blank = wanted.rfind(" D");
        if (blank == wanted.npos || std::string_view(wanted).substr(0, blank) != spindle_)
            return refuse("NC0906", "a tool whose length counts and that was not called before", name,
                          "call it by T and M6");
        edge = std::string_view(wanted).substr(blank + 1);
    }
    line(edge);
    counted_ = wanted;
    forget_linear();
    forget_axis();
    return true;
}

void SinumerikWriter::words_before_motion(const Move& to) {
    if (to.space == Space::machine) plain("SUPA");
    if (to.exact_stop) plain("G9");
}

void SinumerikWriter::vector_words() {
    constexpr std::string_view names[] = {"A3", "B3", "C3"};
    for (std::size_t i = 0; i < 3; ++i)
        if (goal_.axis[i] != 0) word(names[i], vector_grid_, goal_.axis[i]);
}

void SinumerikWriter::turn_words(int turns) {
    plain("TURN=");
    out_.integer(turns);
}

/// In the planes by centre, elsewhere through a point between.
bool SinumerikWriter::arc(const Move& to) {
    const program::Arc& arc = program_.arcs[static_cast<std::size_t>(to.arc)];
    return plane_of(arc) >= 0 ? GCodeWriter::arc(to) : arc_through_point(arc, to);
}

bool SinumerikWriter::arc_through_point(const program::Arc& arc, const Move& to) {
    const Vector3d start = said_mm(), end = goal_mm();
    if ((start + end).hasNaN() || to.kind == program::MoveKind::rapid) return false;
    const Vector3d out = start - arc.centre_mm;
    const double rise = (end - start).dot(arc.normal), half = arc.angle_rad / 2;
    const Vector3d across = out - out.dot(arc.normal) * arc.normal;
    const Vector3d via =
        start - across + std::cos(half) * across + std::sin(half) * arc.normal.cross(across) + rise / 2 * arc.normal;
    const DecimalGrid finer = DecimalGrid::within(0.01 * options_.precision_mm / unit_mm());
    Vector3d read = via;
    for (int i = 0; i < 3; ++i) read[i] = finer.value(finer.steps(via[i] / unit_mm())) * unit_mm();
    const auto made = arc_through(start, read, end);
    const bool same = made && std::abs(rise) < 4 * options_.precision_mm && goes_the_same_way(*made, to);
    if (!same) return false;
    begin_block();
    words_before_motion(to);
    plain("CIP");
    motion_ = -1;
    linear_words();
    constexpr std::string_view names[] = {"I1", "J1", "K1"};
    for (int i = 0; i < 3; ++i) word(names[i], finer, finer.steps(via[i] / unit_mm()));
    orientation_words(to);
    feed_words(to, true);
    out_.end_line();
    arrive(to);
    return true;
}

void SinumerikWriter::plain(std::string_view word) {
    out_.gap();
    out_.put(word);
}

void SinumerikWriter::dwell(double seconds) {
    begin_block();
    plain("G4 F");
    out_.number_within(seconds, options_.feed_precision);
    out_.end_line();
}

/// Where no M6 stands anywhere T itself changes the tool.
bool SinumerikWriter::prepare_tool(std::string_view name) {
    if (!changes_by_m6_ || name.empty() || name.contains('"')) return false;
    prepared_ = name;
    line(call_of(name));
    return true;
}

bool SinumerikWriter::change_tool(std::string_view name) {
    if (!name.empty()) {
        if (name.contains('"')) return false;
        prepared_ = name;
        line(call_of(name));
    }
    if (changes_by_m6_) line("M6");
    if (!prepared_) return true;
    spindle_ = counted_ = *prepared_ == "0" ? "0 D0" : *prepared_;
    forget_linear();
    forget_axis();
    return true;
}

std::unique_ptr<ProgramWriter> make_sinumerik_writer(const program::Program& program, const machine::Machine* machine,
                                                     const WriteOptions& options, const TextSink& sink) {
    return std::make_unique<SinumerikWriter>(program, machine, options, sink);
}

}  // namespace trunnion::nc
