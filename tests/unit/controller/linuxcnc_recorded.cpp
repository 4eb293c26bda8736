#include <cmath>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <sstream>

#include "linuxcnc_running.hpp"

namespace trunnion::controller {
namespace {

/// What LinuxCNC 2.9 took for a program of the shared folder: from its first feed block on, or for all of it.
struct Recorded {
    const char* file;
    const char* mode;  ///< words of path control before the program
    double feed_factor;
    bool whole;
    double seconds, tolerance_s;  ///< half a unit of the last digit that was written down, and some periods
};

void PrintTo(const Recorded& recorded, std::ostream* out) {
    *out << recorded.file;
}

class LinuxcncRecorded : public testing::TestWithParam<Recorded> {};

double seconds_in_feed(const program::Program& program, const std::vector<LinuxcncRow>& rows) {
    std::int32_t first_line = 0;
    for (const program::Move& move : program.moves)
        if (move.kind == program::MoveKind::feed && move.line > first_line) {
            first_line = move.line;
            break;
        }
    std::size_t first = 0, last = 0;
    for (std::size_t k = 1; k < rows.size(); ++k) {
        if (rows[k].axes == rows[k - 1].axes) continue;
        last = k;
        if (first == 0 && rows[k].line >= first_line) first = k;
    }
    return static_cast<double>(last - first + 1) * 0.001;
}

TEST_P(LinuxcncRecorded, takes_the_time_that_the_control_took) {
    const Recorded& recorded = GetParam();
    const std::filesystem::path file = std::filesystem::path(TRUNNION_SHARED_DIR) / "data" / recorded.file;
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    std::stringstream text;
    text << recorded.mode << "\n" << std::ifstream(file).rdbuf();
    const auto machine = recorded_table();
    auto program = program_of(text.str(), machine);
    ASSERT_TRUE(program) << to_string(program.error());
    for (program::Move& move : program->moves)
        move.feed.value *=
            move.feed.rule == program::FeedRule::block_time ? 1 / recorded.feed_factor : recorded.feed_factor;
    std::vector<LinuxcncRow> rows;
    const auto run = run_as_linuxcnc(*program, machine, at_zero(), recorded_settings(),
                                     [&](const LinuxcncRow& row) { rows.push_back(row); });
    ASSERT_TRUE(run) << to_string(run.error());
    EXPECT_NEAR(recorded.whole ? run->cycle_time_s : seconds_in_feed(*program, rows), recorded.seconds,
                recorded.tolerance_s);
}

constexpr const char* mode = "G64 P0.01";

// The impeller's own mode is the control's at the start. At its joints of rotary and merged blocks the control reads a
// value that nobody set, which is worth some periods.
INSTANTIATE_TEST_SUITE_P(Cases, LinuxcncRecorded,
                         testing::Values(Recorded{"cases/fillet.ngc", mode, 1, false, 4.34, 0.009},
                                         Recorded{"cases/corner.ngc", mode, 1, false, 1.414, 0.004},
                                         Recorded{"cases/gentle-0.2.ngc", mode, 1, false, 13.0, 0.053},
                                         Recorded{"cases/gentle-0.5.ngc", mode, 1, false, 8.0, 0.053},
                                         Recorded{"cases/gentle-1.ngc", mode, 1, false, 5.7, 0.053},
                                         Recorded{"cases/sine-10k.ngc", mode, 1, false, 348.5, 0.053},
                                         Recorded{"nc/linuxcnc/impeller-7bl-xyzac.ngc", "", 20, true, 297.54, 0.03}));

}  // namespace
}  // namespace trunnion::controller
