#include "trunnion/pipeline/convert.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/files/output_file.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/helix.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/nc/following.hpp"
#include "trunnion/path/rotary_stands.hpp"

namespace trunnion::pipeline {

using Eigen::Vector3d;
using machine::RotaryPosition;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Program;
using program::Space;

namespace {

constexpr int most_halvings = 14;
constexpr double still_rad = 1e-12;

/// Rotary words of the machine's axes in the order of a program's letters.
class Letters {
  public:
    Letters(const Program& program, const machine::Machine& machine) : count_(machine.rotary_count) {
        for (int a = 0; a < machine.rotary_count; ++a) {
            letters_.push_back(machine.axes[machine.linear_count() + a].letter);
            for (std::size_t i = 0; i < program.rotary_letters.size(); ++i)
                if (program.rotary_letters[i] == letters_.back()) place_[a] = static_cast<int>(i);
        }
    }
    const std::vector<char>& letters() const { return letters_; }

    /// The words of a move, where it has none those of where the axes stand.
    std::array<double, program::max_rotary_letters> words(const Move& move, const RotaryPosition& stand) const {
        std::array<double, program::max_rotary_letters> out{};
        for (int a = 0; a < count_; ++a) {
            const double word = move.law == OrientationLaw::rotary && place_[a] >= 0
                                    ? move.rotary_rad[static_cast<std::size_t>(place_[a])]
                                    : std::nan("");
            out[static_cast<std::size_t>(a)] = std::isnan(word) ? stand[static_cast<std::size_t>(a)] : word;
        }
        return out;
    }

  private:
    int count_;
    std::vector<char> letters_;
    std::array<int, machine::max_rotary_axes> place_{-1, -1};
};

/// Turns a program move by move.
class Translation {
  public:
    Translation(const Program& program, const machine::Machine& machine, const machine::Setup& setup,
                OrientationLaw law, double precision_rad, const std::vector<program::RotaryStand>& stands,
                const machine::Kinematics& kinematics)
        : in_(program),
          setup_(setup),
          law_(law),
          precision_rad_(precision_rad),
          stands_(stands),
          kinematics_(kinematics),
          letters_(program, machine) {}

    Result<Program> run() {
        out_ = in_;
        out_.moves.clear();
        out_.following.clear();
        out_.arcs.clear();
        out_.rotary_letters = letters_.letters();
        std::size_t event = 0, control = 0;
        for (std::size_t k = 0; k <= in_.moves.size(); ++k) {
            const std::size_t here = out_.moves.size();
            for (; event < in_.events.size() && in_.events[event].before_move <= k; ++event)
                out_.events[event].before_move = here;
            for (; control < in_.path_controls.size() && in_.path_controls[control].before_move <= k; ++control)
                out_.path_controls[control].before_move = here;
            if (k == in_.moves.size()) break;
            if (auto added = add(k); !added) return fail(added.error());
        }
        const auto has_words = [](const Move& move) { return move.law == OrientationLaw::rotary; };
        if (std::ranges::none_of(out_.moves, has_words)) out_.rotary_letters.clear();
        tell();
        return std::move(out_);
    }

  private:
    /// One end of a part of a move.
    struct End {
        double share = 0;
        Vector3d axis = Vector3d::UnitZ();  ///< in the workpiece
        RotaryPosition rotary{};
    };

    const Eigen::Matrix3d& offset_of(const Move& move) const {
        static const Eigen::Matrix3d none = Eigen::Matrix3d::Identity();
        const auto found = setup_.offsets.find(in_.offsets[move.offset]);
        return found == setup_.offsets.end() ? none : found->second.rotation;
    }

    Vector3d axis_of(std::size_t k) const {
        const Move& move = in_.moves[k];
        if (move.law == OrientationLaw::vector && move.space == Space::workpiece) return offset_of(move) * move.axis;
        return kinematics_.tool_axis(stands_[k].rotary_rad);
    }

    bool stays(std::size_t k) const {
        const Move& move = in_.moves[k];
        return move.space != Space::workpiece || move.law == law_;
    }

    Result<void> add(std::size_t k) {
        const Move& move = in_.moves[k];
        const RotaryPosition& stand = stands_[k].rotary_rad;
        const bool cuts = k > 0 && move.kind == MoveKind::feed;
        if (stays(k) || !cuts || stands_[k].rebranched) {
            if (!stays(k) && k > 0 && !stands_[k].rebranched) count_rapid(k);
            Move whole = move;
            set_orientation(whole, {1, axis_of(k), stand});
            if (whole.law == OrientationLaw::rotary) whole.rotary_rad = letters_.words(move, stand);
            put(whole, k, 0, 1);
            return {};
        }
        if (move.curve_part != program::no_curve_part) {
            const auto& part = in_.curve_parts[static_cast<std::size_t>(move.curve_part)];
            const auto& curve = in_.curves[static_cast<std::size_t>(part.curve)];
            if (!curve.axis.empty() || !curve.rotary_rad.empty())
                return fail(at(k, "PIPE0014",
                               "a curve that turns the tool is not turned into the other orientation law",
                               "write it in a dialect that has both"));
        }
        const End from{0, axis_of(k - 1), stands_[k - 1].rotary_rad}, to{1, axis_of(k), stand};
        lost_ += law_ == OrientationLaw::vector && differ(from.rotary, to.rotary) &&
                 (from.axis - to.axis).norm() < still_rad;
        const bool one_part = move.curve_part != program::no_curve_part;
        return divide(k, from, to, one_part ? most_halvings : 0, one_part);
    }

    static bool differ(const RotaryPosition& a, const RotaryPosition& b) {
        return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) > still_rad;
    }

    void count_rapid(std::size_t k) {
        if ((axis_of(k) - axis_of(k - 1)).norm() > still_rad) ++rapids_;
    }

    /// The place at a share of the move as its own law leads there.
    End between(std::size_t k, const End& from, const End& to, double share) const {
        End out;
        const double within = (share - from.share) / (to.share - from.share);
        RotaryPosition straight{};
        for (std::size_t a = 0; a < straight.size(); ++a)
            straight[a] = from.rotary[a] + within * (to.rotary[a] - from.rotary[a]);
        out.share = share;
        if (in_.moves[k].law == OrientationLaw::rotary) {
            out.rotary = straight;
            out.axis = kinematics_.tool_axis(straight);
            return out;
        }
        out.axis = geometry::slerp(from.axis, to.axis, within);
        const machine::VectorSeries axis{Taylor3(out.axis.x()), Taylor3(out.axis.y()), Taylor3(out.axis.z())};
        const auto followed = kinematics_.rotary_series(axis, straight);
        for (std::size_t a = 0; a < straight.size(); ++a) out.rotary[a] = followed[a].value();
        return out;
    }

    /// How far the other law leads from this one, rad.
    double difference(std::size_t k, const End& from, const End& to) const {
        double worst = 0;
        for (const double w : {0.21, 0.5, 0.79}) {
            const Vector3d own = between(k, from, to, from.share + w * (to.share - from.share)).axis;
            Vector3d other;
            if (law_ == OrientationLaw::vector) {
                other = geometry::slerp(from.axis, to.axis, w);
            } else {
                RotaryPosition words{};
                for (std::size_t a = 0; a < words.size(); ++a)
                    words[a] = from.rotary[a] + w * (to.rotary[a] - from.rotary[a]);
                other = kinematics_.tool_axis(words);
            }
            worst = std::max(worst, geometry::angle_between(own, other));
        }
        return worst;
    }

    Result<void> divide(std::size_t k, const End& from, const End& to, int halvings, bool whole) {
        if (difference(k, from, to) <= precision_rad_) {
            Move part = in_.moves[k];
            set_orientation(part, to);
            share_feed(part, k, from, to);
            put(part, k, from.share, to.share);
            return {};
        }
        if (halvings >= most_halvings)
            return fail(at(k, whole ? "PIPE0014" : "PIPE0012",
                           whole ? "a curve along which the tool turns is not turned into the other orientation law"
                                 : "the move would fall into more than 16384 parts under the other orientation law",
                           "ask for less precision, or lead the tool past the pole farther away"));
        const End middle = between(k, from, to, 0.5 * (from.share + to.share));
        if (auto first = divide(k, from, middle, halvings + 1, whole); !first) return first;
        return divide(k, middle, to, halvings + 1, whole);
    }

    void set_orientation(Move& move, const End& end) const {
        if (move.space == Space::workpiece) move.law = law_;
        if (move.law == OrientationLaw::vector) move.axis = offset_of(move).transpose() * end.axis;
        move.rotary_rad = {end.rotary[0], end.rotary[1], 0};
    }

    /// A rate of turning keeps the time that it meant.
    void share_feed(Move& part, std::size_t k, const End& from, const End& to) const {
        const double share = to.share - from.share;
        if (part.feed.rule == FeedRule::block_time) part.feed.value *= share;
        if (part.feed.rule != FeedRule::rotary_rate) return;
        const auto words = [](const End& a, const End& b) {
            return std::hypot(b.rotary[0] - a.rotary[0], b.rotary[1] - a.rotary[1]);
        };
        const auto turn = [](const End& a, const End& b) { return geometry::angle_between(a.axis, b.axis); };
        const bool by_words = in_.moves[k].law == OrientationLaw::rotary;
        const double counted = by_words ? words(from, to) : turn(from, to);
        const double counts = by_words ? turn(from, to) : words(from, to);
        if (counted > 0 && counts > 0) part.feed.value *= counts / counted;
    }

    void put(Move part, std::size_t k, double from, double to) {
        if (to < 1) part.exact_stop = false;
        if (k > 0 && (from > 0 || to < 1)) {
            const Move& start = in_.moves[k - 1];
            const Move& end = in_.moves[k];
            if (end.arc == program::no_arc) {
                if (to < 1) part.position_mm = start.position_mm + to * (end.position_mm - start.position_mm);
            } else {
                const program::Arc& arc = in_.arcs[static_cast<std::size_t>(end.arc)];
                const geometry::Helix helix(start.position_mm, end.position_mm, arc.centre_mm, arc.normal,
                                            arc.angle_rad);
                if (to < 1) part.position_mm = helix.at(to);
            }
        }
        if (part.arc != program::no_arc) {
            program::Arc arc = in_.arcs[static_cast<std::size_t>(part.arc)];
            arc.angle_rad *= to - from;
            part.arc = static_cast<std::int32_t>(out_.arcs.size());
            out_.arcs.push_back(arc);
        }
        out_.moves.push_back(part);
        follow(k, to);
    }

    /// The following axes have gone that share of their way along move k.
    void follow(std::size_t k, double share) {
        for (std::size_t i = 0; i < in_.following_letters.size(); ++i) {
            const double end_mm = nc::following_at_end(in_, k, i);
            const double begin_mm = share < 1 ? nc::following_at_begin(in_, k, i) : end_mm;
            out_.following.push_back(begin_mm + share * (end_mm - begin_mm));
        }
    }

    Diagnostic at(std::size_t k, const char* code, const char* text, const char* hint) const {
        return {.code = code, .text = text, .place = {.file = in_.source, .line = in_.moves[k].line}, .hint = hint};
    }

    void tell() {
        if (rapids_ > 0)
            out_.diagnostics.push_back(
                {.code = "PIPE0013",
                 .severity = Severity::warning,
                 .text = "rapids turn the tool otherwise between their ends under the other orientation law",
                 .place = {.file = in_.source},
                 .count = rapids_});
        if (lost_ > 0)
            out_.diagnostics.push_back({.code = "PIPE0015",
                                        .severity = Severity::warning,
                                        .text = "rotary words that leave the tool's direction as it is are left out",
                                        .place = {.file = in_.source},
                                        .count = lost_});
    }

    const Program& in_;
    const machine::Setup& setup_;
    OrientationLaw law_;
    double precision_rad_;
    const std::vector<program::RotaryStand>& stands_;
    const machine::Kinematics& kinematics_;
    Letters letters_;
    Program out_;
    int rapids_ = 0, lost_ = 0;
};

}  // namespace

Result<Program> translate(const Program& program, const machine::Machine& machine, const machine::Setup& setup,
                          OrientationLaw law, double precision_rad) {
    const auto stands = path::choose_rotary_stands(program, machine, setup);
    if (!stands) return fail(stands.error());
    const auto kinematics = machine::Kinematics::make(machine, setup.workpiece, 0);
    if (!kinematics) return fail(kinematics.error());
    return Translation(program, machine, setup, law, precision_rad, *stands, *kinematics).run();
}

Result<nc::WriteSummary> write_program_file(const std::filesystem::path& file, const Program& program,
                                            const machine::Machine* machine, const nc::WriteOptions& options) {
    std::error_code ignored;
    if (std::filesystem::equivalent(file, program.source, ignored))
        return fail({.code = "PIPE0011",
                     .text = "the output would take the place of the program itself",
                     .place = {.file = file.string()},
                     .hint = "give another name behind -o"});
    auto out = files::OutputFile::create(file);
    if (!out) return fail(out.error());
    auto written = nc::write_program(program, machine, options, [&](std::string_view text) { out->write(text); });
    if (!written) return written;
    if (auto done = out->commit(); !done) return fail(done.error());
    return written;
}

}  // namespace trunnion::pipeline
