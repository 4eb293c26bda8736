#include <csignal>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "play_planner.hpp"
#include "player.hpp"

namespace trunnion::test {
namespace {

constexpr double allowed = 1.001;
constexpr std::uint64_t lead_rows = 100;

class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ull + 99) {}
    std::uint64_t below(std::uint64_t n) {
        state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
        return (state_ >> 33) % n;
    }

  private:
    std::uint64_t state_;
};

/// The planner's process: a program under random commands, into the buffer, to its end.
int plan_at_random(trunnion_plans& plans, std::uint64_t seed) {
    const machine::Machine machine = peer_machine();
    OnePart parts(random_program(seed, 3), machine);
    auto motion = pipeline::LiveMotion::make(parts, machine, {}, {}, 2);
    if (!motion) return 2;
    app::PlanPublisher publisher(*motion, [&](const auto& row) { return app::row_of(row, machine); }, plans, lead_rows);
    if (!publisher.publish_begin()) return 3;
    Random random(seed);
    for (;;) {
        const auto advance = publisher.advance();
        if (!advance) return 4;
        if (advance->status == pipeline::LiveMotionStatus::finished && publisher.reader_stands()) return 0;
        switch (random.below(400)) {
            case 0:
                motion->hold();
                break;
            case 1:
                (void)motion->set_feed_override(0.1 * static_cast<double>(random.below(20)));
                break;
            case 2:
                (void)motion->set_rapid_override(0.25 * static_cast<double>(1 + random.below(4)));
                break;
            default:
                if (random.below(20) == 0) {
                    motion->resume();
                    (void)motion->set_feed_override(1);
                }
        }
        usleep(20);
    }
}

/// Two processes over one buffer; the reader is this one, a period takes 20 µs.
class TwoProcesses {
  public:
    explicit TwoProcesses(std::uint64_t seed)
        : plans_(static_cast<trunnion_plans*>(
              mmap(nullptr, sizeof(trunnion_plans), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
        trunnion_plans_begin(plans_, 5, period_s);
        (void)trunnion_reader_begin(&reader_, plans_);
        writer_ = fork();
        if (writer_ == 0) _exit(plan_at_random(*plans_, seed));
    }
    ~TwoProcesses() {
        if (writer_ > 0) {
            kill(writer_, SIGKILL);
            waitpid(writer_, nullptr, 0);
        }
        munmap(plans_, sizeof(trunnion_plans));
    }
    TwoProcesses(const TwoProcesses&) = delete;
    TwoProcesses& operator=(const TwoProcesses&) = delete;

    /// One period; whether there was a row.
    bool period(RowCheck& check) {
        usleep(20);
        trunnion_look(&reader_);
        const trunnion_row* row = trunnion_next_row(&reader_);
        if (row) check.note(*row);
        return row != nullptr;
    }
    void signal(int what) const { kill(writer_, what); }
    void kill_writer() {
        kill(writer_, SIGKILL);
        waitpid(writer_, nullptr, 0);
        writer_ = -1;
    }
    bool writer_ended(int& status) {
        if (waitpid(writer_, &status, WNOHANG) != writer_) return false;
        writer_ = -1;
        return true;
    }

  private:
    trunnion_plans* plans_;
    trunnion_reader reader_{};
    pid_t writer_ = -1;
};

const machine::Machine& the_machine() {
    static const machine::Machine machine = peer_machine();
    return machine;
}

TEST(TwoProcesses, AKilledWriterEndsInAStandstillInsideAllLimits) {
    int in_motion = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        TwoProcesses both(seed);
        RowCheck check(the_machine());
        Random random(1000 + seed);
        const std::uint64_t rows = 1 + random.below(4000);
        for (int k = 0; k < 400000 && check.rows() < rows; ++k) both.period(check);
        both.kill_writer();
        const std::uint64_t before = check.rows();
        while (both.period(check)) {}
        for (int k = 0; k < 10; ++k) EXPECT_FALSE(both.period(check));
        in_motion += check.rows() > before;
        check.stand();
        EXPECT_LE(check.worst(), allowed);
    }
    EXPECT_GT(in_motion, 4);
}

TEST(TwoProcesses, AWriterThatIsHeldUpAndGoesOnBreaksNoLimit) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        SCOPED_TRACE(seed);
        TwoProcesses both(seed);
        RowCheck check(the_machine());
        Random random(2000 + seed);
        int status = -1;
        for (int k = 0; k < 2000000 && !both.writer_ended(status); ++k) {
            if (random.below(2000) == 0) {
                both.signal(SIGSTOP);
                for (std::uint64_t late = random.below(1500); late > 0; --late) both.period(check);
                both.signal(SIGCONT);
            }
            both.period(check);
        }
        EXPECT_EQ(status, 0);
        check.stand();
        EXPECT_LE(check.worst(), allowed);
        EXPECT_GT(check.rows(), 3000u);
    }
}

TEST(TwoProcesses, AReaderThatPausesBreaksNoLimit) {
    TwoProcesses both(7);
    RowCheck check(the_machine());
    Random random(7);
    int status = -1;
    for (int k = 0; k < 2000000 && !both.writer_ended(status); ++k) {
        if (random.below(3000) == 0) usleep(static_cast<useconds_t>(random.below(30000)));
        both.period(check);
    }
    EXPECT_EQ(status, 0);
    check.stand();
    EXPECT_LE(check.worst(), allowed);
}

}  // namespace
}  // namespace trunnion::test
