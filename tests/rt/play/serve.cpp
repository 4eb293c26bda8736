// `serve` against a stand-in for LinuxCNC's module that does what trunnion_tp.c does with the shared memory.
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

#include <gtest/gtest.h>

#include "player.hpp"
#include "serve_server.hpp"

namespace trunnion::test {
namespace {

using app::OrderServer;
using app::WorldPoses;

/// The servo thread's side: orders in, a row a period out. Poses are X Y Z A C.
class Module {
  public:
    explicit Module(trunnion_tp_memory& memory) : memory_(memory) {
        trunnion_plans_begin(&memory.plans, 9, period_s);
        trunnion_reader_begin(&reader_, &memory.plans);
        memory.orders.period_s = period_s;
        memory.orders.feed_scale = 1;
        memory.orders.run_through = TRUNNION_RUN_ALL;
        memory.orders.largest_speed = 1e3;
        memory.format = TRUNNION_TP_FORMAT;
        at_.position[2] = 50;
    }
    void begin() {
        trunnion_order order = order_to(at_.position, trunnion_order_begin);
        order.epoch = ++epoch_;
        order.number = number_;
        ASSERT_TRUE(trunnion_order_write(&memory_.orders, &order));
    }
    void line(const std::array<double, 5>& to, double speed, int joint = trunnion_joint_blend) {
        double end[9] = {to[0], to[1], to[2], to[3], 0, to[4]};
        trunnion_order order = order_to(end, trunnion_order_line);
        order.number = ++number_;
        order.speed = speed;
        order.joint = joint;
        ASSERT_TRUE(trunnion_order_write(&memory_.orders, &order));
    }
    /// One servo period; whether a row came.
    bool cycle(bool looks = true) {
        memory_.orders.cycles = memory_.orders.cycles + 1;
        if (!planner_answers()) return false;
        if (looks) trunnion_look(&reader_);
        const trunnion_row* row = trunnion_next_row(&reader_);
        if (!row) return false;
        at_ = *row;
        return true;
    }
    bool done() const {
        return memory_.orders.done_through >= number_ && memory_.orders.read == memory_.orders.written;
    }
    const trunnion_row& at() const { return at_; }
    std::uint64_t number() const { return number_; }
    std::uint32_t epoch() const { return epoch_; }

  private:
    /// Plans of an earlier epoch are given up, as trunnion_tp.c does.
    bool planner_answers() {
        const bool answered = memory_.orders.answered == epoch_;
        if (answered && greeted_ == epoch_) return true;
        const std::uint64_t newest = __atomic_load_n(&memory_.plans.published, __ATOMIC_ACQUIRE);
        reader_.in_use = 0;
        reader_.looked_at = newest;
        __atomic_store_n(&memory_.plans.in_use, 0, __ATOMIC_RELAXED);
        __atomic_store_n(&memory_.plans.looked_at, newest, __ATOMIC_RELEASE);
        if (answered) greeted_ = epoch_;
        return answered;
    }
    trunnion_order order_to(const double (&end)[9], int kind) const {
        trunnion_order out{};
        out.kind = kind;
        out.epoch = epoch_;
        std::ranges::copy(end, out.end);
        out.joint = trunnion_joint_blend;
        return out;
    }
    trunnion_tp_memory& memory_;
    trunnion_reader reader_{};
    trunnion_row at_{};
    std::uint64_t number_ = 0;
    std::uint32_t epoch_ = 0, greeted_ = 0;
};

struct Served {
    app::Workplace workplace{.machine = peer_machine()};
    std::unique_ptr<trunnion_tp_memory> memory = std::make_unique<trunnion_tp_memory>();
    Module module{*memory};
    std::atomic<bool> ended{false};
    std::thread planner{[this] {
        for (OrderServer server(*memory, workplace); !ended; std::this_thread::yield()) server.work();
    }};
    ~Served() {
        ended = true;
        planner.join();
    }
    /// What the axes make of a pose.
    trunnion_row axes_at(const trunnion_row& world) const {
        const auto poses = WorldPoses::make(workplace.machine, 0);
        const auto kinematics = machine::Kinematics::make(workplace.machine, {}, 0);
        const auto pose = poses->pose_of(world.position);
        const auto linear = kinematics->linear_for(pose.tip_mm, pose.rotary_rad);
        trunnion_row out{};
        std::ranges::copy(linear, out.position);
        for (int i = 0; i < 2; ++i) out.position[3 + i] = pose.rotary_rad[i] / degree;
        return out;
    }
};

TEST(Serve, MovesWhileOrdersComeInAndHoldsLimits) {
    Served served;
    RowCheck check(served.workplace.machine);
    check.note(served.axes_at(served.module.at()));
    served.module.begin();
    constexpr int all = 600;
    int sent = 0, rows = 0, stood = 0;
    bool moved = false;
    for (int k = 0; k < 1000000 && !(sent == all && served.module.done() && moved && stood > 200); ++k) {
        if (sent < all && sent < rows + 300) {
            const double x = 0.2 * ++sent;
            served.module.line({x, 5 * std::sin(x / 10), 50, 5 + 5 * std::sin(x / 12), 8 * std::sin(x / 15)}, 80);
        }
        const bool came = served.module.cycle();
        moved = moved || came;
        stood = came ? 0 : stood + 1;
        rows += came;
        if (came) check.note(served.axes_at(served.module.at()));
        std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
    EXPECT_TRUE(served.module.done());
    EXPECT_LE(check.worst(), 1.001);
    EXPECT_NEAR(served.module.at().position[0], 0.2 * all, 1e-9);
    EXPECT_EQ(served.module.at().line, all);
    EXPECT_EQ(served.memory->orders.refused, 0u);
}

TEST(Serve, AbortStandsAndTheNextBeginGoesOn) {
    Served served;
    RowCheck check(served.workplace.machine);
    check.note(served.axes_at(served.module.at()));
    auto& module = served.module;
    auto& orders = served.memory->orders;
    module.begin();
    module.line({100, 0, 50, 0, 0}, 50);
    const auto cycle = [&] {
        if (module.cycle()) check.note(served.axes_at(module.at()));
        std::this_thread::sleep_for(std::chrono::microseconds(50));
    };
    for (int k = 0; k < 100000 && module.at().position[0] < 20; ++k) cycle();
    orders.run_through = 0;
    orders.aborted = module.epoch();
    for (int k = 0; k < 100000 && orders.stopped != module.epoch(); ++k) cycle();
    for (int k = 0; k < 1000; ++k) cycle();
    EXPECT_EQ(orders.stopped, module.epoch());
    const double stood_at = module.at().position[0];
    EXPECT_GT(stood_at, 20);
    EXPECT_LT(stood_at, 60);
    orders.run_through = TRUNNION_RUN_ALL;
    orders.aborted = 0;
    const std::uint64_t published = served.memory->plans.published;
    for (int k = 0; k < 200; ++k) cycle();
    EXPECT_EQ(served.memory->plans.published, published) << "an aborted motion goes on";
    module.begin();
    module.line({0, 0, 50, 0, 0}, 50, trunnion_joint_stop);
    for (int k = 0; k < 200000 && !module.done(); ++k) cycle();
    for (int k = 0; k < 5000; ++k) cycle();
    EXPECT_NEAR(module.at().position[0], 0, 1e-9);
    EXPECT_LE(check.worst(), 1.001);
}

TEST(Serve, StepsStandAtTheEndOfTheMove) {
    Served served;
    RowCheck check(served.workplace.machine);
    check.note(served.axes_at(served.module.at()));
    auto& module = served.module;
    auto& orders = served.memory->orders;
    orders.run_through = 0;
    module.begin();
    for (int k = 1; k <= 10; ++k) module.line({10.0 * k, k % 2 * 5.0, 50, 0, 2.0 * k}, 50);
    const auto run_through = [&](std::uint64_t number) {
        for (int k = 0, stood = 0; k < 200000 && (stood < 300 || orders.done_through < number); ++k) {
            const bool came = module.cycle();
            stood = came ? 0 : stood + 1;
            if (came) check.note(served.axes_at(module.at()));
            std::this_thread::sleep_for(std::chrono::microseconds(20));
        }
    };
    run_through(0);
    EXPECT_EQ(check.rows(), 1u);
    for (const std::uint64_t step : {1, 2, 3}) {
        orders.run_through = step;
        run_through(step);
        EXPECT_EQ(orders.done_through, step);
        EXPECT_EQ(module.at().line, static_cast<std::int64_t>(step));
        EXPECT_NEAR(module.at().position[0], 10.0 * static_cast<double>(step), 0.02);
        orders.run_through = 0;
        run_through(step);
    }
    orders.run_through = TRUNNION_RUN_ALL;
    run_through(10);
    EXPECT_TRUE(module.done());
    EXPECT_NEAR(module.at().position[0], 100, 1e-9);
    EXPECT_LE(check.worst(), 1.001);
}

/// As where LinuxCNC leaves coordinated mode under way: no row is taken, and the next program is begun soon.
TEST(Serve, ABeginIsAnsweredThoughThePlanBeforeWasNotLookedAt) {
    Served served;
    auto& module = served.module;
    auto& orders = served.memory->orders;
    module.begin();
    module.line({100, 0, 50, 0, 0}, 50);
    for (int k = 0; k < 100000 && module.at().position[0] < 5; ++k) {
        module.cycle();
        std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
    orders.run_through = 0;  // a plan is made that nobody looks at
    const std::uint64_t published = served.memory->plans.published;
    for (int k = 0; k < 1000 && served.memory->plans.published == published; ++k) {
        module.cycle(false);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_NE(served.memory->plans.published, published);
    module.begin();
    int waited_ms = 0;
    for (; waited_ms < 3000 && orders.answered != module.epoch(); ++waited_ms)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_LT(waited_ms, 1000);
    orders.run_through = TRUNNION_RUN_ALL;
    module.line({0, 0, 50, 0, 0}, 50, trunnion_joint_stop);
    for (int k = 0; k < 200000 && !(module.done() && module.at().position[0] < 1e-9); ++k) {
        module.cycle();
        std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
    EXPECT_NEAR(module.at().position[0], 0, 1e-9);
}

TEST(Serve, TellsWhatCannotBePlanned) {
    Served served;
    served.module.begin();
    served.module.line({90000, 0, 50, 0, 0}, 50);
    for (int k = 0; k < 100000 && served.memory->orders.refused == 0; ++k) {
        EXPECT_FALSE(served.module.cycle());
        std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
    EXPECT_EQ(served.memory->orders.refused, 1u);
    EXPECT_NE(std::string(served.memory->orders.reason).find("PATH0102"), std::string::npos);
}

TEST(Serve, ArcsTurnAsLinuxcncCountsThem) {
    const machine::Machine machine = peer_machine();
    const auto poses = WorldPoses::make(machine, 30);
    ASSERT_TRUE(poses);
    pipeline::QueuedPose begin;
    begin.tip_mm = {10, 0, -30};
    trunnion_order order{};
    order.kind = trunnion_order_arc;
    order.normal[2] = 1;
    order.end[0] = 0;
    order.end[1] = 10;
    const auto angle = [&](int turn) {
        order.turn = turn;
        return app::move_of(order, begin, *poses).arc->angle_rad / std::numbers::pi;
    };
    EXPECT_NEAR(angle(0), 0.5, 1e-12);
    EXPECT_NEAR(angle(1), 2.5, 1e-12);
    EXPECT_NEAR(angle(-1), -1.5, 1e-12);
    EXPECT_NEAR(angle(-2), -3.5, 1e-12);
    order.end[0] = 10;
    order.end[1] = 0;
    EXPECT_NEAR(angle(0), 2, 1e-12);
    EXPECT_NEAR(angle(-1), -2, 1e-12);
    EXPECT_NEAR(app::move_of(order, begin, *poses).end.tip_mm.z(), -30, 1e-12);
}

TEST(Serve, PosesComeBackAsTheyWent) {
    const machine::Machine machine = peer_machine();
    const auto poses = WorldPoses::make(machine, 42);
    const double world[9] = {10, -20, 55, 12, 0, -33};
    const auto kinematics = machine::Kinematics::make(machine, {}, 42);
    const auto pose = poses->pose_of(world);
    const auto linear = kinematics->linear_for(pose.tip_mm, pose.rotary_rad);
    pipeline::LiveRow row{.line = 5};
    for (int i = 0; i < 3; ++i) row.position[i] = linear[i];
    for (int i = 0; i < 2; ++i) row.position[3 + i] = pose.rotary_rad[i];
    const trunnion_row back = poses->row_of(row);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(back.position[i], world[i], 1e-12) << i;
    EXPECT_EQ(back.line, 5);
}

TEST(Serve, RefusesAxesThatLinuxcncHasNot) {
    machine::Machine machine = peer_machine();
    machine.axes[0].letter = 'W';
    EXPECT_EQ(WorldPoses::make(machine, 0).error().code, "RT0101");
}

}  // namespace
}  // namespace trunnion::test
