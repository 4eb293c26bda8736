// A program in parts moves as the whole one does.
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/pipeline/check_setpoints.hpp"
#include "trunnion/pipeline/programmed.hpp"
#include "trunnion/verify/check.hpp"
#include "trunnion/verify/setpoint_table.hpp"

#include "planned.hpp"

namespace trunnion::pipeline {
namespace {

using program::Program;

/// A program cut before every `length`th rapid; behind part number `breaks` comes an error.
class Cut final : public program::ProgramParts {
  public:
    Cut(const Program& whole, int length, int breaks = -1) : breaks_(breaks) {
        Program part = empty_like(whole);
        part.moves.push_back(whole.moves.front());
        std::size_t event = 0;
        int rapids = 0;
        for (std::size_t k = 1; k < whole.moves.size(); ++k) {
            if (whole.moves[k].kind == program::MoveKind::rapid && k > 1 && ++rapids % length == 0) {
                parts_.push_back(part);
                part = empty_like(whole);
                part.moves.push_back(whole.moves[k - 1]);
            }
            for (; event < whole.events.size() && whole.events[event].before_move <= k; ++event) {
                part.events.push_back(whole.events[event]);
                part.events.back().before_move = part.moves.size();
            }
            part.moves.push_back(whole.moves[k]);
        }
        for (; event < whole.events.size(); ++event) {
            part.events.push_back(whole.events[event]);
            part.events.back().before_move = part.moves.size();
        }
        part.diagnostics = whole.diagnostics;
        parts_.push_back(part);
    }
    Result<bool> next(Program& part) override {
        if (given_ == breaks_) return fail({.code = "NC9999", .text = "unreadable"});
        if (static_cast<std::size_t>(given_) == parts_.size()) return false;
        part = parts_[static_cast<std::size_t>(given_++)];
        return true;
    }
    double share() const override { return static_cast<double>(given_) / static_cast<double>(parts_.size()); }
    std::size_t count() const { return parts_.size(); }

  private:
    static Program empty_like(const Program& whole) {
        Program part = whole;
        part.moves.clear();
        part.events.clear();
        part.diagnostics.clear();
        return part;
    }
    std::vector<Program> parts_;
    int given_ = 0, breaks_;
};

struct InParts {
    Recorder recorder;
    std::vector<std::string> words;
    Result<Summary> summary;
    InParts(const machine::Machine& machine, program::ProgramParts& parts, const PlanOptions& options = {}) {
        summary = plan(parts, machine, {}, options, recorder);
    }
};

/// Passes with the tool leaning, a rapid before each and an event behind; the axes C and A go on winding.
std::string passes(int count, bool vectors) {
    std::string text = vectors ? "UNITS/MM\nMULTAX/ON\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/2000,MMPM\n"
                               : "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nF2000\n";
    for (int k = 0; k < count; ++k) {
        const double turn = 0.4 * k, tilt = 0.3 + 0.1 * std::sin(k);
        const auto pose = [&](double x, double z, double more) {
            const double c = turn + more;
            text += vectors ? fmt::format("GOTO/{:.4f},{},{:.4f},{:.9f},{:.9f},{:.9f}\n", x, k, z,
                                          std::sin(tilt) * std::cos(c), std::sin(tilt) * std::sin(c), std::cos(tilt))
                            : fmt::format("X{:.4f} Y{} Z{:.4f} A{:.6f} C{:.6f}\n", x, k, z, 57 * tilt, 57 * c);
        };
        text += vectors ? "RAPID\n" : "G0 ";
        pose(0, 50, 0);
        text += vectors ? "" : "G1 ";
        for (int i = 0; i <= 10; ++i) pose(i, std::sin(0.5 * i), 0.05 * i);
        text += vectors ? "COOLNT/ON\n" : "M8\n";
    }
    return text + (vectors ? "FINI\n" : "M2\n");
}

void expect_same_motion(const Recorder& parts, const Recorder& whole) {
    ASSERT_EQ(parts.rows.size(), whole.rows.size());
    for (std::size_t k = 0; k < whole.rows.size(); ++k) {
        ASSERT_EQ(parts.rows[k].line, whole.rows[k].line) << k;
        ASSERT_EQ(parts.rows[k].time_s, whole.rows[k].time_s) << k;
        for (int i = 0; i < machine::max_axes; ++i)
            ASSERT_NEAR(parts.rows[k].position[i], whole.rows[k].position[i], 1e-9) << k << " axis " << i;
    }
}

TEST(PlanInParts, moves_as_the_whole_program_does) {
    for (const bool vectors : {false, true}) {
        const Planned whole(passes(12, vectors));
        ASSERT_TRUE(whole.summary) << to_string(whole.summary.error());
        for (const int length : {1, 3, 5, 100})
            for (const int threads : {1, 2}) {
                Cut cut(whole.program, length);
                EXPECT_EQ(cut.count() == 1, length == 100);
                PlanOptions options;
                options.threads = threads;
                const InParts parts(whole.machine, cut, options);
                ASSERT_TRUE(parts.summary) << to_string(parts.summary.error());
                expect_same_motion(parts.recorder, whole.recorder);
                EXPECT_EQ(parts.recorder.events.size(), whole.recorder.events.size());
                EXPECT_EQ(parts.summary->cycle_time_s, whole.summary->cycle_time_s);
                EXPECT_EQ(parts.summary->blocks, whole.summary->blocks);
                EXPECT_EQ(parts.summary->exact_stops.total, whole.summary->exact_stops.total);
                EXPECT_EQ(parts.summary->tolerance_used, whole.summary->tolerance_used);
                EXPECT_EQ(parts.summary->program, "test.ngc");
                EXPECT_EQ(parts.summary->diagnostics.size(), whole.summary->diagnostics.size());
                EXPECT_TRUE(std::ranges::is_sorted(parts.recorder.shares));
                EXPECT_NEAR(parts.recorder.shares.back(), 1, 1e-12);
            }
    }
}

/// Free to choose, the axes would begin a part on another branch or winding than the one before left them on.
TEST(PlanInParts, goes_on_as_the_axes_stand) {
    const std::string first = "UNITS/MM\nMULTAX/ON\nGOTO/0,0,0,0.3,0,0.95\nFEDRAT/2000,MMPM\n";
    std::string text = first;
    for (int k = 1; k <= 60; ++k)
        text += fmt::format("GOTO/{},0,0,{:.9f},{:.9f},0.95\n", k, 0.3 * std::cos(0.2 * k), 0.3 * std::sin(0.2 * k));
    Planned whole(text + "FINI\n");
    ASSERT_TRUE(whole.summary);
    for (std::size_t stop = 10; stop < 60; stop += 10) whole.program.moves[stop].exact_stop = true;
    struct AtStops final : program::ProgramParts {
        explicit AtStops(const Program& program) : whole(program) {}
        Result<bool> next(Program& part) override {
            part = whole;
            const std::size_t first = at, behind = std::min<std::size_t>(at + 11, whole.moves.size());
            if (first + 1 >= whole.moves.size()) return false;
            part.moves.assign(whole.moves.begin() + static_cast<std::ptrdiff_t>(first),
                              whole.moves.begin() + static_cast<std::ptrdiff_t>(behind));
            at = behind - 1;
            return true;
        }
        const Program& whole;
        std::size_t at = 0;
    } cut(whole.program);
    const InParts parts(whole.machine, cut);
    ASSERT_TRUE(parts.summary) << to_string(parts.summary.error());
    EXPECT_EQ(parts.summary->exact_stops.total, 5u);
    const auto& rows = parts.recorder.rows;
    EXPECT_NEAR(std::abs(rows.back().position[4] - rows.front().position[4]), 12, 1e-6) << "rad: C winds up";
    for (std::size_t k = 1; k < rows.size(); ++k)
        for (int i = 3; i < 5; ++i)
            ASSERT_LT(std::abs(rows[k].position[i] - rows[k - 1].position[i]),
                      1.001e-3 * whole.machine.axes[i].feed.velocity)
                << k << " axis " << i;
}

/// Pairs of passes at one azimuth, the second with a tilt that one branch alone can do: the first, looked at alone, is
/// nearer by the other branch.
std::string pairs_of_passes(int count) {
    std::string text = "UNITS/MM\nMULTAX/ON\nRAPID\nGOTO/0,0,50,0.295520207,0,0.955336489\nFEDRAT/2000,MMPM\n";
    for (int k = 0; k < count; ++k) {
        const double tilt = k % 2 == 0 ? 0.3 : 0.9;
        for (int i = -1; i <= 6; ++i) {
            const double c = 1.92 * (k / 2 + 1) + 0.02 * std::max(i, 0);
            text += i < 0 ? "RAPID\n" : "";
            text += fmt::format("GOTO/{},{},{:.4f},{:.9f},{:.9f},{:.9f}\n", 2 * std::max(i, 0), k,
                                i < 0 ? 50 : std::sin(0.5 * i), std::sin(tilt) * std::cos(c),
                                std::sin(tilt) * std::sin(c), std::cos(tilt));
        }
    }
    return text + "FINI\n";
}

double largest_stand_difference_rad(const std::vector<verify::ProgrammedPose>& a,
                                    const std::vector<verify::ProgrammedPose>& b) {
    double out = 0;
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
        for (std::size_t r = 0; r < a[k].rotary_rad.size(); ++r)
            if (std::isfinite(a[k].rotary_rad[r]) && std::isfinite(b[k].rotary_rad[r]))
                out = std::max(out, std::abs(a[k].rotary_rad[r] - b[k].rotary_rad[r]));
    return out;
}

/// What is checked has branch and winding of the parts, not of the whole.
TEST(PlanInParts, is_checked_by_the_poses_of_the_same_parts) {
    machine::Machine machine = files::read_machine(test_table, "test.toml").value();
    machine.axes[3].range_min = -0.5;
    const Planned whole(machine, pairs_of_passes(12));
    ASSERT_TRUE(whole.summary) << to_string(whole.summary.error());
    const smoothing::SmoothingOptions tolerances = PlanOptions{}.smoothing;
    Cut cut(whole.program, 1), again(whole.program, 1), uncut(whole.program, 1000);
    const InParts parts(whole.machine, cut);
    ASSERT_TRUE(parts.summary) << to_string(parts.summary.error());
    const auto of_parts = programmed_poses(again, whole.machine, {}, tolerances);
    const auto of_whole = programmed_poses(uncut, whole.machine, {}, tolerances);
    ASSERT_TRUE(of_parts && of_whole);
    EXPECT_EQ(of_parts->poses.size(), of_whole->poses.size());
    EXPECT_GT(largest_stand_difference_rad(of_parts->poses, of_whole->poses), 1) << "else nothing is tested here";
    const auto table = verify::setpoint_table(parts.recorder.rows);
    ASSERT_TRUE(table);
    verify::CheckOptions options;
    options.tip_tolerance_mm = tolerances.tip_tolerance_mm;
    options.orientation_tolerance_rad = tolerances.orientation_tolerance_rad;
    const auto verdict = verify::check(*table, of_parts->poses, whole.machine, {}, options);
    ASSERT_TRUE(verdict) << to_string(verdict.error());
    EXPECT_TRUE(verdict->ok) << pipeline::report(*verdict);
}

TEST(PlanInParts, says_the_error_of_the_reader_behind_what_came_before) {
    const Planned whole(passes(6, false));
    for (const int breaks : {0, 1, 2, 4}) {
        Cut cut(whole.program, 1, breaks);
        const InParts parts(whole.machine, cut);
        ASSERT_FALSE(parts.summary);
        EXPECT_EQ(parts.summary.error().code, "NC9999");
        EXPECT_EQ(parts.recorder.rows.empty(), breaks < 2) << "two parts are looked at before motion begins";
    }
}

TEST(PlanInParts, looks_for_no_worth_and_says_so) {
    const Planned whole(passes(6, false));
    PlanOptions options;
    options.worth = true;
    Cut several(whole.program, 2), one(whole.program, 100);
    const InParts parts(whole.machine, several, options), in_one(whole.machine, one, options);
    ASSERT_TRUE(parts.summary && in_one.summary);
    const auto tells = [](const Summary& summary) {
        return std::ranges::any_of(summary.diagnostics, [](const auto& d) { return d.code == "PIPE0106"; });
    };
    EXPECT_TRUE(tells(*parts.summary));
    EXPECT_TRUE(parts.summary->worth.empty());
    EXPECT_FALSE(tells(*in_one.summary));
    EXPECT_FALSE(in_one.summary->worth.empty());
}

TEST(PlanInParts, can_be_cancelled) {
    const Planned whole(passes(12, false));
    Cut cut(whole.program, 1);
    InParts parts(whole.machine, cut);
    Recorder recorder;
    recorder.calls_until_cancel = 5;
    Cut again(whole.program, 1);
    const auto summary = plan(again, whole.machine, {}, {}, recorder);
    ASSERT_FALSE(summary);
    EXPECT_EQ(summary.error().code, "PIPE0002");
}

}  // namespace
}  // namespace trunnion::pipeline
