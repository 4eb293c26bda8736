#include "trunnion/pipeline/queue_motion.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace trunnion::test {
namespace {

using pipeline::LiveMotionStatus;
using pipeline::LiveRow;
using pipeline::QueuedMove;
using pipeline::QueueMotion;

constexpr double period_s = 1e-3;

const machine::Machine& table() {
    static const auto machine = *files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/xyzac-trt.toml");
    return machine;
}

/// A wave of dense 5-axis blocks, 0.2 mm in X each.
QueuedMove wave(int number) {
    QueuedMove out;
    const double x = 0.2 * number - 190;
    out.number = number;
    out.end.tip_mm = {x, 10 * std::sin(x / 15), 3 * std::sin(x / 7)};
    out.end.rotary_rad = {0.2 * std::sin(x / 20), 0.4 * std::sin(x / 30)};
    out.feed = {program::FeedRule::tip_speed, 10000 / 60.0};
    return out;
}

QueuedMove line(int number, double x, double y, double a = 0, double c = 0) {
    QueuedMove out;
    out.number = number;
    out.end.tip_mm = {x, y, 0};
    out.end.rotary_rad = {a, c};
    out.feed = {program::FeedRule::tip_speed, 100};
    return out;
}

/// Runs a queue and holds every row against the limits by differences.
class QueueDrive {
  public:
    explicit QueueDrive(const pipeline::QueuedPose& begin, const pipeline::QueueOptions& options = {})
        : motion_(*QueueMotion::make(table(), 0, begin, options)) {
        rows_.push_back(motion_.begin());
    }
    QueueMotion& motion() { return motion_; }
    const std::vector<LiveRow>& rows() const { return rows_; }
    int standstills() const { return standstills_; }
    /// From here on three of four plans come too late for the axes.
    void refuse_most() { refuses_ = true; }
    void take_all() { refuses_ = false; }
    int refused() const { return refused_; }

    LiveMotionStatus tick() {
        expected_.reset();
        if (ahead_.size() > next_) expected_ = ahead_[next_];
        const auto state = motion_.tick();
        if (!state) {
            ADD_FAILURE() << to_string(state.error());
            return LiveMotionStatus::finished;
        }
        ++next_;
        const bool late = refuses_ && motion_.plan() != plan_ && ahead_.size() > next_ + 200 && ++changes_ % 4 != 0;
        if (late) {
            EXPECT_EQ(*expected_, state->row);
            motion_.take_back_plan(0);
            ++refused_;
            plan_ = motion_.plan();
        } else if (motion_.plan() != plan_) {
            plan_ = motion_.plan();
            motion_.rows_ahead(ahead_);
            next_ = 0;
            motion_.keep_plan(0);
        } else if (expected_ && state->status == LiveMotionStatus::moving) {
            EXPECT_EQ(*expected_, state->row) << "row " << rows_.size() << " is not as planned";
        }
        if (state->status != LiveMotionStatus::moving && last_ == LiveMotionStatus::moving) ++standstills_;
        last_ = state->status;
        rows_.push_back(state->row);
        return state->status;
    }
    void run_until_waiting() {
        for (int k = 0; k < 200000 && tick() != LiveMotionStatus::waiting; ++k) {}
    }
    /// The largest of what the rows' differences make of velocity, acceleration and jerk, of the limits.
    double worst() const {
        double worst = 0;
        for (std::size_t k = 3; k < rows_.size(); ++k)
            for (int i = 0; i < table().axis_count; ++i) {
                const machine::AxisLimits& limit = table().axes[i].feed;
                const auto at = [&](int back) { return rows_[k - back].position[i]; };
                worst =
                    std::max({worst, std::abs(at(0) - at(1)) / period_s / limit.velocity,
                              std::abs(at(0) - 2 * at(1) + at(2)) / std::pow(period_s, 2) / limit.acceleration,
                              std::abs(at(0) - 3 * at(1) + 3 * at(2) - at(3)) / std::pow(period_s, 3) / limit.jerk});
            }
        return worst;
    }

  private:
    QueueMotion motion_;
    std::vector<LiveRow> rows_, ahead_;
    std::optional<LiveRow> expected_;
    std::size_t plan_ = 0, next_ = 0;
    int standstills_ = 0, refused_ = 0, changes_ = 0;
    bool refuses_ = false;
    LiveMotionStatus last_ = LiveMotionStatus::waiting;
};

constexpr double in_limits = 1.001, tip_tolerance_mm = 0.02;

TEST(QueueMotion, GoesOnWhileMovesComeIn) {
    constexpr int all = 1900;
    QueueDrive drive(wave(0).end);
    int sent = 0;
    std::size_t moving = 0;
    for (int k = 0; k < 100000; ++k) {
        if (sent < all) drive.motion().add(wave(++sent));
        if (sent == all) drive.motion().close();
        const auto status = drive.tick();
        moving += status == LiveMotionStatus::moving;
        if (sent == all && status == LiveMotionStatus::waiting) break;
    }
    EXPECT_EQ(drive.standstills(), 1);
    EXPECT_EQ(drive.motion().done_at_standstill(), all);
    EXPECT_LE(drive.worst(), in_limits);

    QueueDrive whole(wave(0).end);
    for (int k = 1; k <= all; ++k) whole.motion().add(wave(k));
    whole.motion().close();
    whole.run_until_waiting();
    EXPECT_EQ(whole.standstills(), 1);
    EXPECT_LE(static_cast<double>(moving), 1.005 * static_cast<double>(whole.rows().size()));
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(drive.rows().back().position[i], whole.rows().back().position[i], 1e-9);
}

TEST(QueueMotion, StandsWhereItIsAskedTo) {
    QueueDrive drive({});
    QueuedMove first = line(1, 20, 0), second = line(2, 20, 20, 0.1), third = line(3, 0, 20, 0.1, 0.2);
    first.exact_stop = true;
    third.stop_first = true;
    for (const QueuedMove& move : {first, second, third}) drive.motion().add(move);
    drive.motion().close();
    drive.run_until_waiting();
    EXPECT_LE(drive.worst(), in_limits);
    int at_corner = 0;
    for (std::size_t k = 1; k < drive.rows().size(); ++k) {
        const auto &at = drive.rows()[k].position, &was = drive.rows()[k - 1].position;
        double way = 0;
        for (int i = 0; i < 5; ++i) way = std::max(way, std::abs(at[i] - was[i]));
        at_corner += way < 1e-6 && k > 10 && k + 10 < drive.rows().size();
    }
    EXPECT_GT(at_corner, 2);
}

TEST(QueueMotion, TurnsAnArc) {
    QueueDrive drive({});
    drive.motion().add(line(1, 20, 0));
    QueuedMove arc = line(2, 30, 10);
    arc.arc = program::Arc{{20, 10, 0}, {0, 0, 1}, std::numbers::pi / 2};
    drive.motion().add(arc);
    drive.motion().add(line(3, 30, 30));
    drive.motion().close();
    drive.run_until_waiting();
    EXPECT_EQ(drive.standstills(), 1);
    EXPECT_LE(drive.worst(), in_limits);
    double off = 0;
    int on_arc = 0;
    for (const LiveRow& row : drive.rows()) {
        const double x = row.position[0] - 20, y = row.position[1] - 10;
        if (x < 1 || y > -1) continue;
        ++on_arc;
        off = std::max(off, std::abs(std::hypot(x, y) - 10));
    }
    EXPECT_GT(on_arc, 20);
    EXPECT_LE(off, 0.021);
}

TEST(QueueMotion, WaitsForEnoughOrForTheLast) {
    QueueDrive drive({});
    drive.motion().add(line(1, 5, 0));
    EXPECT_EQ(drive.tick(), LiveMotionStatus::waiting);
    drive.motion().close();
    EXPECT_EQ(drive.tick(), LiveMotionStatus::moving);
    drive.run_until_waiting();
    EXPECT_EQ(drive.motion().done_at_standstill(), 1);
    drive.motion().add(line(2, 5, 0));  // leads nowhere
    drive.motion().close();
    EXPECT_EQ(drive.tick(), LiveMotionStatus::waiting);
    EXPECT_EQ(drive.motion().done_at_standstill(), 2);
}

TEST(QueueMotion, HoldsAndGoesOn) {
    QueueDrive drive(wave(0).end);
    for (int k = 1; k <= 600; ++k) drive.motion().add(wave(k));
    drive.motion().close();
    for (int k = 0; k < 500; ++k) drive.tick();
    drive.motion().hold();
    for (int k = 0; k < 1000; ++k) drive.tick();
    EXPECT_EQ(drive.tick(), LiveMotionStatus::standing);
    EXPECT_LT(drive.motion().done_at_standstill(), 600);
    for (int k = 601; k <= 900; ++k) drive.motion().add(wave(k));
    drive.motion().close();
    drive.motion().resume();
    drive.motion().set_override(0.5);
    drive.run_until_waiting();
    EXPECT_EQ(drive.motion().done_at_standstill(), 900);
    EXPECT_LE(drive.worst(), in_limits);
}

/// The largest speed counts for moves that are queued, and on a leg that is begun later; turns do not follow it.
TEST(QueueMotion, KeepsALargestSpeed) {
    QueueDrive drive({});
    drive.motion().add(line(1, 100, 0));
    QueuedMove rapid = line(2, 0, 0), turn = line(3, 0, 0, 0.5);
    rapid.rapid = true;
    turn.feed = {program::FeedRule::rotary_rate, 1};
    drive.motion().add(rapid);
    drive.motion().add(turn);
    drive.motion().close();
    for (int k = 0; k < 500; ++k) drive.tick();
    drive.motion().set_largest_speed(20);
    for (int k = 0; k < 300; ++k) drive.tick();
    const std::size_t slow = drive.rows().size();
    drive.run_until_waiting();
    double fastest = 0, turns = 0;
    for (std::size_t k = slow; k < drive.rows().size(); ++k) {
        const auto &at = drive.rows()[k].position, &was = drive.rows()[k - 1].position;
        if (drive.rows()[k].line < 3) fastest = std::max(fastest, std::abs(at[0] - was[0]) / period_s);
        turns = std::max(turns, std::abs(at[3] - was[3]) / period_s);
    }
    EXPECT_LE(fastest, 20 * in_limits);
    EXPECT_GT(fastest, 19.9);
    EXPECT_GT(turns, 0.5);
    EXPECT_LE(drive.worst(), in_limits);
}

/// Plans that came too late are taken back: the one before goes on, row by row, and the next trial counts farther
/// ahead.
TEST(QueueMotion, GoesOnWhereLongerPlansCameTooLate) {
    QueueDrive drive(wave(0).end);
    drive.refuse_most();
    for (int k = 0, sent = 0; k < 100000; ++k) {
        if (sent < 1900) drive.motion().add(wave(++sent));
        if (sent == 1900) drive.motion().close();
        if (drive.tick() == LiveMotionStatus::waiting && sent == 1900) break;
    }
    EXPECT_GT(drive.refused(), 5);
    EXPECT_EQ(drive.standstills(), 1);
    EXPECT_EQ(drive.motion().done_at_standstill(), 1900);
    EXPECT_LE(drive.worst(), in_limits);
    EXPECT_NEAR(drive.rows().back().position[4], wave(1900).end.rotary_rad[1], 1e-9);
}

/// A hold is made at once and counts soon, though longer ways have been taken back and count far ahead.
TEST(QueueMotion, AHoldDoesNotWaitForALongerWay) {
    QueueDrive drive(wave(0).end);
    drive.refuse_most();
    for (int k = 1; k <= 1000; ++k) drive.motion().add(wave(k));
    for (int k = 0; k < 3000 && drive.refused() < 3; ++k) drive.tick();
    ASSERT_EQ(drive.refused(), 3);
    drive.take_all();
    drive.motion().hold();
    int ticks = 0;
    while (drive.tick() == LiveMotionStatus::moving && ticks < 3000) ++ticks;
    EXPECT_LT(ticks, 600);
    EXPECT_LE(drive.worst(), in_limits);
}

/// How far the tip is from a move's end.
double off_mm(const LiveRow& row, const QueuedMove& move) {
    const auto kinematics = *machine::Kinematics::make(table(), {}, 0);
    return (kinematics.forward(row.position).tip_in_workpiece_mm - move.end.tip_mm).norm();
}

/// Corners that are rounded, a turn on the spot, an exact stop and a rapid, stepped through from the begin.
TEST(QueueMotion, StepsFromMoveToMove) {
    std::vector<QueuedMove> moves{
        line(1, 20, 0), line(2, 20, 20, 0.1), line(3, 20, 20, 0.2, 0.5), line(4, 0, 20, 0.1, 0.2), line(5, 0, 0),
        line(6, 30, 0), line(7, 30, 5)};
    moves[3].exact_stop = true;
    moves[5].rapid = true;
    QueueDrive drive({});
    for (const QueuedMove& move : moves) drive.motion().add(move);
    drive.motion().close();
    drive.motion().hold();
    for (int k = 0; k < 10; ++k) drive.tick();
    EXPECT_EQ(drive.standstills(), 0);
    for (const QueuedMove& move : moves) {
        drive.motion().step_through(move.number);
        drive.motion().resume();
        for (int k = 0; k < 5000 && drive.tick() != LiveMotionStatus::moving; ++k) {}
        for (int k = 0; k < 5000 && drive.tick() == LiveMotionStatus::moving; ++k) {}
        for (int k = 0; k < 200; ++k) EXPECT_NE(drive.tick(), LiveMotionStatus::moving);
        EXPECT_EQ(drive.motion().done_at_standstill(), move.number);
        EXPECT_EQ(drive.rows().back().line, move.number);
        EXPECT_LE(off_mm(drive.rows().back(), move), tip_tolerance_mm) << move.number;
        drive.motion().hold();
        for (int k = 0; k < 50; ++k) EXPECT_NE(drive.tick(), LiveMotionStatus::moving);
    }
    EXPECT_EQ(drive.standstills(), static_cast<int>(moves.size()));
    EXPECT_LE(drive.worst(), in_limits);
}

/// In the middle of a run: a step goes to the end of the present move, or of the next one that can be met; behind some
/// of them it runs on, also where moves have come meanwhile, without one more standstill.
TEST(QueueMotion, StepsUnderWayAndRunsOn) {
    QueueDrive drive(wave(0).end);
    for (int k = 1; k <= 400; ++k) drive.motion().add(wave(k));
    drive.motion().close();
    for (int k = 0; k < 400; ++k) drive.tick();
    for (int step = 0; step < 5; ++step) {
        const int line = step == 0 ? drive.rows().back().line : drive.motion().done_at_standstill() + 1;
        drive.motion().step_through(line);
        drive.motion().resume();
        for (int k = 0; k < 3000; ++k) drive.tick();
        const int stood = drive.rows().back().line;
        EXPECT_EQ(drive.motion().done_at_standstill(), stood);
        EXPECT_LE(off_mm(drive.rows().back(), wave(stood)), tip_tolerance_mm);
        EXPECT_EQ(drive.standstills(), step + 1);
        EXPECT_TRUE(stood == line || step == 0) << stood;
    }
    EXPECT_LT(drive.rows().back().line, 200);
    for (int k = 401; k <= 1900; ++k) drive.motion().add(wave(k));
    drive.motion().close();
    drive.motion().step_through(drive.rows().back().line + 1);
    drive.motion().resume();
    for (int k = 0; k < 3000; ++k) drive.tick();
    EXPECT_EQ(drive.standstills(), 6);
    drive.motion().step_through(std::nullopt);
    drive.motion().resume();
    drive.run_until_waiting();
    EXPECT_EQ(drive.motion().done_at_standstill(), 1900);
    EXPECT_EQ(drive.standstills(), 7);
    EXPECT_LE(drive.worst(), in_limits);
}

TEST(QueueMotion, RefusesWhatIsOutOfRange) {
    auto motion = *QueueMotion::make(table(), 0, {}, {});
    motion.add(line(7, 5000, 0));
    motion.close();
    const auto state = motion.tick();
    ASSERT_FALSE(state);
    EXPECT_EQ(state.error().code, "PATH0102");
    EXPECT_EQ(state.error().place.line, 7);
    EXPECT_EQ(QueueMotion::make(table(), 0, {}, {.plan = {.period_s = 0}}).error().code, "PIPE0001");
}

}  // namespace
}  // namespace trunnion::test
