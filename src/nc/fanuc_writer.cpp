#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/curves.hpp"
#include "detail/g_code_writer.hpp"

namespace trunnion::nc {

using program::Curve;
using program::CurvePart;
using program::FeedRule;
using program::Move;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr int most_nurbs_degree = 3;
constexpr int motion_of_nurbs = -2;
constexpr double knot_precision = 1e-9;  ///< share; of weights too

/// ISO code for FANUC and its like: G43.4 for rotary words, G43.5 for tool vectors (I J K), G43 and G49 with TCP off.
/// Every number has its point. Curves as G06.2.
class FanucWriter final : public GCodeWriter {
  public:
    FanucWriter(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                const TextSink& sink)
        : GCodeWriter(program, machine, options, sink, Habits{.numbers = {.point_always = true}}) {}

  private:
    /// What G43 … G49 have switched to.
    enum class Tcp : std::uint8_t { unsaid, off, by_words, by_vectors };

    void head() override {
        line("%");
        line("O0001");
        head_comments();
        line(options_.units == Units::inch ? "G20 G90 G94 G17 G40 G80 G49" : "G21 G90 G94 G17 G40 G80 G49");
    }

    void tail() override {
        if (!ends_itself()) line("M30");
        out_.put("%");
        out_.end_line();
    }

    bool enter(const Move& to) override {
        if (to.space != space_) {
            forget_linear();
            forget_axis();
        }
        space_ = to.space;
        return (to.space == Space::machine || (count_offset(to) && transform(tcp_of(to), to))) && curve_fits(to);
    }

    static Tcp tcp_of(const Move& to) {
        if (to.space == Space::untransformed) return Tcp::off;
        return to.law == OrientationLaw::vector ? Tcp::by_vectors : Tcp::by_words;
    }

    bool count_offset(const Move& to) {
        if (to.offset == offset_) return true;
        const std::string& name = offset_name(to);
        const std::string word = name.empty() ? "G54" : name;
        const bool plain = word.size() == 3 && word >= "G54" && word <= "G59";
        if (!plain && !word.starts_with("G54.1 P"))
            return refuse("NC0905", "no such work offset in this dialect", name, "G54 … G59 and G54.1 P1 … are there");
        line(word);
        offset_ = to.offset;
        forget_linear();
        forget_axis();
        return true;
    }

    /// The tool's length counts by its number, with TCP off too.
    bool transform(Tcp wanted, const Move& to) {
        const std::string& name = tool_name(to);
        if (tcp_ == wanted && name == counted_) return true;
        const bool length_off = name.ends_with(" D0");
        if (!length_off && name.find_first_not_of("0123456789") != name.npos)
            return refuse("NC0906", "a tool whose length cannot be called in this dialect", name,
                          "tools are numbers here");
        const std::string length = name.empty() ? "1" : name;
        const bool on = wanted != Tcp::off;
        if (length_off && on)
            return refuse("NC0906", "TCP with a tool whose length does not count", name, "call the tool's length");
        if (tcp_ == Tcp::by_words || tcp_ == Tcp::by_vectors) line("G49");
        if (on) line((wanted == Tcp::by_words ? "G43.4 H" : "G43.5 H") + length);
        if (!on && !length_off && !name.empty()) line("G43 H" + length);
        if (!on && length_off && tcp_ == Tcp::off) line("G49");
        tcp_ = wanted;
        counted_ = name;
        forget_linear();
        forget_axis();
        return true;
    }

    void words_before_motion(const Move& to) override {
        if (to.exact_stop) plain("G09");
        if (to.space == Space::machine) plain("G53");
    }

    void vector_words() override {
        constexpr std::string_view names[] = {"I", "J", "K"};
        for (std::size_t i = 0; i < 3; ++i) word(names[i], vector_grid_, goal_.axis[i]);
    }

    /// I J K are the tool's under G43.5.
    bool arc(const Move& to) override { return to.law != OrientationLaw::vector && GCodeWriter::arc(to); }
    bool takes_turns() const override { return false; }

    void dwell(double seconds) override {
        begin_block();
        out_.gap();
        out_.put("G4 X");
        out_.number_within(seconds, options_.feed_precision, habits_.numbers);
        out_.end_line();
    }

    // ------------------------------------------------------------------------------------------------------- curves

    /// Where NURBS are asked for nothing else is written.
    bool curve_fits(const Move& to) {
        const bool asked = options_.curves == CurveForm::nurbs && to.curve_part != program::no_curve_part;
        if (!asked || index_ == 0 || moves_of_nurbs(index_) > 0) return true;
        return refuse("NC0909", "a curve that does not fit into G06.2", {},
                      "degree 1 to 3, rotary words, G94 and a known start, or straight moves");
    }

    const CurvePart& part_of(std::size_t move) const {
        return program_.curve_parts[static_cast<std::size_t>(program_.moves[move].curve_part)];
    }

    /// How many moves from here on are one G06.2, which has one feed; 0: it cannot say them.
    std::size_t moves_of_nurbs(std::size_t first) const {
        const bool wanted = options_.curves == CurveForm::own || options_.curves == CurveForm::nurbs;
        const Curve* const curve = curve_followed(program_, first);
        if (!wanted || options_.inverse_time || !curve || curve->degree > most_nurbs_degree) return 0;
        const Move& begin = program_.moves[first];
        const bool by_words = begin.law == OrientationLaw::rotary && begin.space != Space::machine;
        if (!by_words || begin.feed.rule != FeedRule::tip_speed || said_mm().hasNaN()) return 0;
        const std::size_t most = moves_along_curve(program_, first);
        std::size_t count = 0;
        while (count < most && program_.moves[first + count].feed == begin.feed) ++count;
        if (count == 0 || !turns_by_itself(first, count)) return count;
        return curve->weights.empty() && is_one_polynomial(*curve, part_of(first)) ? 1 : 0;
    }

    /// Whether the rotary words turn along these moves though the curve does not say how.
    bool turns_by_itself(std::size_t first, std::size_t count) const {
        if (!curve_followed(program_, first)->rotary_rad.empty()) return false;
        for (std::size_t k = first; k < first + count; ++k)
            for (std::size_t i = 0; i < program_.rotary_letters.size(); ++i) {
                const double to = program_.moves[k].rotary_rad[i];
                if (!std::isnan(to) && to != program_.moves[k - 1].rotary_rad[i]) return true;
            }
        return false;
    }

    static bool is_one_polynomial(const Curve& curve, const CurvePart& part) {
        return std::ranges::none_of(curve.knots, [&](double u) { return part.from_u < u && u < part.to_u; });
    }

    /// Control points from where the tool stands on, each with a knot, then as many knots more as the order is. G61
    /// stands outside: a curve is one motion.
    std::size_t curve(std::size_t first) override {
        const std::size_t count = moves_of_nurbs(first);
        if (count == 0) return 0;
        const Move& last = program_.moves[first + count - 1];
        if (!aim(last)) return 0;
        Curve piece =
            part_of_curve(*curve_followed(program_, first), part_of(first).from_u, part_of(first + count - 1).to_u);
        if (turns_by_itself(first, count)) turn_evenly(program_.moves[first - 1], last, piece);
        if (last.exact_stop) line("G61");
        const std::size_t points = piece.position_mm.size();
        for (std::size_t i = 0; i < points; ++i) {
            begin_block();
            if (i == 0) plain(fmt::format("G06.2 P{}.", piece.degree + 1));
            knot(piece.knots[i]);
            control_words(piece, i);
            if (i == 0) feed_words(last, true);
            out_.end_line();
        }
        for (std::size_t i = points; i < piece.knots.size(); ++i) {
            begin_block();
            knot(piece.knots[i]);
            out_.end_line();
        }
        if (last.exact_stop) line("G64");
        motion_ = motion_of_nurbs;
        arrive(last);
        return count;
    }

    /// In proportion to the parameter, so that control points say it evenly.
    static void turn_evenly(const Move& from, const Move& to, Curve& piece) {
        for (int i = 0; i <= piece.degree; ++i) {
            auto& words = piece.rotary_rad.emplace_back(to.rotary_rad);
            for (std::size_t k = 0; k < words.size(); ++k)
                if (!std::isnan(from.rotary_rad[k]))
                    words[k] = from.rotary_rad[k] + i * (to.rotary_rad[k] - from.rotary_rad[k]) / piece.degree;
        }
    }

    void knot(double u) {
        plain("K");
        out_.number_within(u, knot_precision, habits_.numbers);
    }

    /// The first point is where the text has led to, the last one is the goal.
    void control_words(const Curve& piece, std::size_t point) {
        constexpr std::string_view names[] = {"X", "Y", "Z"};
        const bool first = point == 0, last = point + 1 == piece.position_mm.size();
        for (std::size_t i = 0; i < 3; ++i) {
            const double value = piece.position_mm[point][static_cast<Eigen::Index>(i)] / unit_mm();
            word(names[i], linear_grid_, first ? said_.linear[i] : last ? goal_.linear[i] : linear_grid_.steps(value));
        }
        for (std::size_t i = 0; i < program_.rotary_letters.size() && !piece.rotary_rad.empty(); ++i)
            if (const double value = piece.rotary_rad[point][i] / degree; !std::isnan(value))
                word({&program_.rotary_letters[i], 1}, rotary_grid_, rotary_grid_.steps(value));
        if (piece.weights.empty()) return;
        plain("R");
        out_.number_within(piece.weights[point], knot_precision, habits_.numbers);
    }

    void plain(std::string_view word) {
        out_.gap();
        out_.put(word);
    }

    bool prepare_tool(std::string_view name) override {
        if (name.empty() || name.find_first_not_of("0123456789") != name.npos) return false;
        line(fmt::format("T{}", name));
        return true;
    }

    bool change_tool(std::string_view name) override {
        if (!name.empty() && !prepare_tool(name)) return false;
        line("M6");
        return true;
    }

    std::optional<std::uint16_t> offset_;
    Space space_ = Space::untransformed;
    Tcp tcp_ = Tcp::unsaid;
    std::string counted_;
};

}  // namespace

std::unique_ptr<ProgramWriter> make_fanuc_writer(const program::Program& program, const machine::Machine* machine,
                                                 const WriteOptions& options, const TextSink& sink) {
    return std::make_unique<FanucWriter>(program, machine, options, sink);
}

}  // namespace trunnion::nc
