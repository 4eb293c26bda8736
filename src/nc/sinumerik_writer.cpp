#include <algorithm>
#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/g_code_writer.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Move;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr double reference_mm = 1 / degree;  ///< FGREF as delivered
constexpr int most_spline_degree = 3;
constexpr double heaviest_point = 3;      // PW
constexpr double second_height_mm = 100;  // XH YH ZH lie so far up a vector of length 1
constexpr double knot_precision = 1e-9;   // share

/// Whether the first and the last control points are the ends of the curve.
bool is_clamped(const program::Curve& curve) {
    const auto& knots = curve.knots;
    return knots.front() == knots[static_cast<std::size_t>(curve.degree)] &&
           knots.back() == knots[curve.position_mm.size()];
}

/// SINUMERIK 840D. Vectors under TRAORI and ORIVECT, rotary words under TRAORI and ORIAXES; D0 where SUPA says Z.
class SinumerikWriter final : public GCodeWriter {
  public:
    SinumerikWriter(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                    const TextSink& sink)
        : GCodeWriter(program, machine, options, sink,
                      Habits{.comment_begin = ';', .comment_end = 0, .turn_mm = reference_mm, .arcs = sinumerik_arcs}),
          changes_by_m6_(says_m6(program)) {}

  private:
    static bool says_m6(const program::Program& program) {
        return std::ranges::any_of(program.events, [](const program::Event& event) {
            const auto actions = actions_of(event);
            return actions.front().kind == Action::Kind::change_tool && !event.word.starts_with('T');
        });
    }

    void head() override {
        head_comments();
        if (!program_.curves.empty())
            comment("BSPLINE: both ends are taken to be knots of full multiplicity; PL=0 stands beside them");
        line(options_.units == Units::inch ? "G17 G40 G700 G90 G94 G64" : "G17 G40 G710 G90 G94 G64");
    }

    void tail() override {
        if (!ends_itself()) line("M30");
    }

    bool enter(const Move& to) override {
        const bool in_machine = to.space == Space::machine;
        if (!count_tool(to, in_machine)) return false;
        if (to.space != space_) {
            forget_linear();
            forget_axis();
            space_ = to.space;
        }
        if (in_machine) return transform(false);
        if (!count_offset(to) || !transform(to.space == Space::workpiece)) return false;
        if (to.space == Space::workpiece) turn_by(mode_of(to));
        return true;
    }

    /// A vector from which a curve with tool vectors begins is said as the second point of that curve.
    std::string_view mode_of(const Move& to) const {
        if (to.law == OrientationLaw::rotary) return "ORIAXES";
        return second_curve(index_) || second_curve(index_ + 1) ? "ORIWKS ORICURVE" : "ORIWKS ORIVECT";
    }

    const program::Curve* curve_of(std::size_t move) const {
        if (move >= program_.moves.size() || program_.moves[move].curve_part == program::no_curve_part) return nullptr;
        const auto& part = program_.curve_parts[static_cast<std::size_t>(program_.moves[move].curve_part)];
        return &program_.curves[static_cast<std::size_t>(part.curve)];
    }
    /// The curve with tool vectors that moves[move] begins.
    const program::Curve* second_curve(std::size_t move) const {
        const program::Curve* const curve = curve_of(move);
        return curve && moves_of_curve(move) > 0 && !curve->axis.empty() ? curve : nullptr;
    }

    bool transform(bool on) {
        if (transform_ == on) return true;
        if (transform_ || on) line(on ? "TRAORI" : "TRAFOOF");
        transform_ = on;
        forget_linear();
        forget_axis();
        return true;
    }

    void turn_by(std::string_view mode) {
        if (mode_ == mode) return;
        line(mode);
        mode_ = mode;
        forget_axis();
    }

    bool count_offset(const Move& to) {
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

    static bool knows_offset(std::string_view word) {
        if (word.size() == 3) return word >= "G54" && word <= "G57";
        return word == "G500" || (word.size() == 4 && word >= "G505" && word <= "G599");
    }

    /// The cutting edge whose length counts. SUPA counts Z with the tool's length unless D0 is said.
    bool count_tool(const Move& to, bool in_machine) {
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

    void words_before_motion(const Move& to) override {
        if (to.space == Space::machine) plain("SUPA");
        if (to.exact_stop) plain("G9");
    }

    void orientation_words(const Move& to) override {
        const program::Curve* const next = to.law == OrientationLaw::vector ? second_curve(index_ + 1) : nullptr;
        if (!next) return GCodeWriter::orientation_words(to);
        second_words(goal_mm(), next->axis.front());
        second_said_ = &program_.moves[index_];
    }

    void second_words(const Vector3d& tip_mm, const Vector3d& axis) {
        constexpr std::string_view names[] = {"XH", "YH", "ZH"};
        const Vector3d second = (tip_mm + second_height_mm * axis) / unit_mm();
        for (int i = 0; i < 3; ++i) word(names[i], linear_grid_, linear_grid_.steps(second[i]));
    }

    void vector_words() override {
        constexpr std::string_view names[] = {"A3", "B3", "C3"};
        for (std::size_t i = 0; i < 3; ++i)
            if (goal_.axis[i] != 0) word(names[i], vector_grid_, goal_.axis[i]);
    }

    void turn_words(int turns) override {
        plain("TURN=");
        out_.integer(turns);
    }

    /// In the planes by centre, elsewhere through a point between.
    bool arc(const Move& to) override {
        const program::Arc& arc = program_.arcs[static_cast<std::size_t>(to.arc)];
        return plane_of(arc) >= 0 ? GCodeWriter::arc(to) : arc_through_point(arc, to);
    }

    bool arc_through_point(const program::Arc& arc, const Move& to) {
        const Vector3d start = said_mm(), end = goal_mm();
        if ((start + end).hasNaN() || to.kind == program::MoveKind::rapid) return false;
        const Vector3d out = start - arc.centre_mm;
        const double rise = (end - start).dot(arc.normal), half = arc.angle_rad / 2;
        const Vector3d across = out - out.dot(arc.normal) * arc.normal;
        const Vector3d via = start - across + std::cos(half) * across + std::sin(half) * arc.normal.cross(across) +
                             rise / 2 * arc.normal;
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

    /// How many moves from here on are the whole of one curve that BSPLINE can say; 0: they are not.
    std::size_t moves_of_curve(std::size_t first) const {
        const program::Curve* const curve = curve_of(first);
        if (!curve || curve->degree > most_spline_degree || !is_clamped(*curve)) return 0;
        const auto heavy = [](double weight) { return weight > heaviest_point; };
        if (std::ranges::any_of(curve->weights, heavy)) return 0;
        const Move& begin = program_.moves[first];
        const bool by_itself = begin.law == OrientationLaw::vector ? curve->axis.empty() : curve->rotary_rad.empty();
        double u = curve->knots.front();
        std::size_t k = first;
        for (; k < program_.moves.size() && curve_of(k) == curve; ++k) {
            const Move& move = program_.moves[k];
            const auto& part = program_.curve_parts[static_cast<std::size_t>(move.curve_part)];
            const bool goes_on = part.from_u == u && move.space == begin.space && move.offset == begin.offset &&
                                 move.tool == begin.tool && move.law == begin.law &&
                                 move.kind == program::MoveKind::feed;
            if (!goes_on || (k > first && (event_at(k) || (by_itself && turns(program_.moves[k - 1], move))))) return 0;
            u = part.to_u;
        }
        const bool turns_first = first > 0 && turns(program_.moves[first - 1], begin);
        if (u != curve->knots.back() || first == 0 || (by_itself && turns_first)) return 0;
        return k - first;
    }

    static bool turns(const Move& from, const Move& to) {
        return from.law != to.law ||
               (to.law == OrientationLaw::vector ? from.axis != to.axis : from.rotary_rad != to.rotary_rad);
    }

    bool event_at(std::size_t move) const {
        const auto event = std::ranges::lower_bound(program_.events, move, {}, &program::Event::before_move);
        return event != program_.events.end() && event->before_move == move;
    }

    /// Control points from the second on, PL=0 beside the ends, the spans between them in order.
    std::size_t curve(std::size_t first) override {
        const std::size_t count = moves_of_curve(first);
        if (count == 0) return 0;
        const program::Curve& curve = *curve_of(first);
        if (!curve.axis.empty() && second_said_ != &program_.moves[first - 1]) say_second_point(first, curve);
        const auto degree = static_cast<std::size_t>(curve.degree), points = curve.position_mm.size();
        const std::size_t in_front = degree > 1 ? 1 : 0, spans = points - degree;
        std::size_t move = first;
        for (std::size_t b = 1; b < points; ++b) {
            const bool has_span = b > in_front && b <= in_front + spans;
            const std::size_t knot = degree + b - in_front - 1;
            const double length = has_span ? curve.knots[knot + 1] - curve.knots[knot] : 0;
            const Move& to = program_.moves[move];
            if (!aim(to)) return 0;
            begin_block();
            if (b + 1 == points) words_before_motion(program_.moves[first + count - 1]);
            if (b == 1) {
                plain("BSPLINE SD=");
                out_.integer(curve.degree);
            }
            control_words(curve, b, to);
            plain("PL=");
            out_.number_within(length / unit_mm(), knot_precision);
            if (!curve.weights.empty()) {
                plain("PW=");
                out_.number_within(curve.weights[b], knot_precision);
            }
            feed_words(to, true);
            out_.end_line();
            if (length > 0 && move + 1 < first + count) ++move;
        }
        motion_ = -1;
        if (!aim(program_.moves[first + count - 1])) return 0;
        arrive(program_.moves[first + count - 1]);
        second_said_ = nullptr;
        forget_axis();
        return count;
    }

    void control_words(const program::Curve& curve, std::size_t point, const Move& to) {
        constexpr std::string_view names[] = {"X", "Y", "Z"};
        const Vector3d& position = curve.position_mm[point];
        for (int i = 0; i < 3; ++i) word(names[i], linear_grid_, linear_grid_.steps(position[i] / unit_mm()));
        if (!curve.axis.empty()) {
            Vector3d written = position;
            for (int i = 0; i < 3; ++i)
                written[i] = linear_grid_.value(linear_grid_.steps(position[i] / unit_mm())) * unit_mm();
            second_words(written, curve.axis[point]);
        }
        if (to.law != OrientationLaw::rotary || curve.rotary_rad.empty()) return;
        for (std::size_t i = 0; i < program_.rotary_letters.size(); ++i)
            word({&program_.rotary_letters[i], 1}, rotary_grid_,
                 rotary_grid_.steps(curve.rotary_rad[point][i] / degree));
    }

    /// Where the tool stands, once more, as the start of both curves.
    void say_second_point(std::size_t first, const program::Curve& curve) {
        begin_block();
        motion_word(1);
        second_words(said_mm(), curve.axis.front());
        if (aim(program_.moves[first])) feed_words(program_.moves[first], true);
        out_.end_line();
    }

    void plain(std::string_view word) {
        out_.gap();
        out_.put(word);
    }

    void dwell(double seconds) override {
        begin_block();
        plain("G4 F");
        out_.number_within(seconds, options_.feed_precision);
        out_.end_line();
    }

    static std::string call_of(std::string_view name) {
        const bool number = name.find_first_not_of("0123456789") == name.npos;
        return number ? fmt::format("T{}", name) : fmt::format("T=\"{}\"", name);
    }

    /// Where no M6 stands anywhere T itself changes the tool.
    bool prepare_tool(std::string_view name) override {
        if (!changes_by_m6_ || name.empty() || name.contains('"')) return false;
        prepared_ = name;
        line(call_of(name));
        return true;
    }

    bool change_tool(std::string_view name) override {
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

    bool changes_by_m6_;
    Space space_ = Space::untransformed;
    bool transform_ = false;
    std::string_view mode_;              ///< of orientation
    const Move* second_said_ = nullptr;  ///< the move that said the second point of the curve behind it
    std::optional<std::uint16_t> offset_;
    std::string spindle_, counted_;
    std::optional<std::string> prepared_;
};

}  // namespace

std::unique_ptr<ProgramWriter> make_sinumerik_writer(const program::Program& program, const machine::Machine* machine,
                                                     const WriteOptions& options, const TextSink& sink) {
    return std::make_unique<SinumerikWriter>(program, machine, options, sink);
}

}  // namespace trunnion::nc
