// The publisher against a motion whose plans take as long as the test says.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "play_planner.hpp"
#include "player.hpp"

namespace trunnion::test {
namespace {

using pipeline::LiveMotionState;
using pipeline::LiveMotionStatus;
using pipeline::LiveRow;

constexpr std::uint64_t lead_rows = 200;

/// Takes so many rows as there is time for, and looks for plans always.
class Reader {
  public:
    explicit Reader(trunnion_plans& plans) : plans_(plans) {
        (void)trunnion_reader_begin(&reader_, &plans);
        thread_ = std::thread([this] { run(); });
    }
    ~Reader() {
        ended_ = true;
        thread_.join();
    }
    void let_pass(std::uint64_t periods) {
        const std::uint64_t until = __atomic_load_n(&plans_.next, __ATOMIC_ACQUIRE) + periods;
        until_ = until;
        while (__atomic_load_n(&plans_.next, __ATOMIC_ACQUIRE) < until) std::this_thread::yield();
    }

  private:
    void run() {
        for (; !ended_; std::this_thread::yield()) {
            trunnion_look(&reader_);
            if (reader_.next < until_) (void)trunnion_next_row(&reader_);
        }
    }
    trunnion_plans& plans_;
    trunnion_reader reader_{};
    std::atomic<std::uint64_t> until_{0};
    std::atomic<bool> ended_{false};
    std::thread thread_;
};

/// Moves one unit a row to a standstill 5000 rows on; a plan that is asked for moves twice as far from 250 rows ahead
/// on.
class Slow final : public pipeline::LiveRows {
  public:
    explicit Slow(Reader& reader) : reader_(reader) {}
    std::uint64_t planning_takes = 0;
    bool wanted = false;
    int taken_back = 0;
    std::size_t lead_asked_for = 0;

    LiveRow begin() const override { return row(0); }
    Result<LiveMotionState> tick(bool may_plan) override {
        if (plans_ == 0) plans_ = 1;
        if (may_plan && wanted) {
            wanted = false;
            kept_from_ = from_;
            from_ = at_ + 250;
            reader_.let_pass(planning_takes);
            ++plans_;
        }
        ticked_at_lead += may_plan;
        LiveMotionState out;
        out.status = LiveMotionStatus::moving;
        out.row = row(++at_);
        return out;
    }
    std::size_t plan() const override { return plans_; }
    void rows_ahead(std::vector<LiveRow>& rows) const override {
        rows.clear();
        for (std::size_t k = at_ + 1; k <= 5000; ++k) rows.push_back(row(k));
    }
    void keep_plan(std::size_t lead) override { lead_asked_for = lead; }
    void take_back_plan(std::size_t lead) override {
        from_ = kept_from_;
        lead_asked_for = lead;
        ++taken_back;
        ++plans_;
    }
    std::size_t at() const { return at_; }
    int ticked_at_lead = 0;

  private:
    LiveRow row(std::size_t k) const {
        LiveRow out;
        out.position[0] = static_cast<double>(k + (k > from_ ? k - from_ : 0));
        return out;
    }
    Reader& reader_;
    std::size_t at_ = 0, plans_ = 0, from_ = 1000000, kept_from_ = 1000000;
};

struct LatePlans : testing::Test {
    std::unique_ptr<trunnion_plans> plans = [] {
        auto out = std::make_unique<trunnion_plans>();
        trunnion_plans_begin(out.get(), 5, period_s);
        return out;
    }();
    Reader reader{*plans};
    Slow motion{reader};
    machine::Machine machine = peer_machine();
    app::PlanPublisher publisher{motion, [this](const LiveRow& row) { return app::row_of(row, machine); }, *plans,
                                 lead_rows};

    void advance() { ASSERT_TRUE(publisher.advance()); }
    void begin() {
        ASSERT_TRUE(publisher.publish_begin());
        for (int k = 0; k < 10; ++k) advance();
    }
};

TEST_F(LatePlans, APlanThatComesInTimeIsKeptAndSaysHowLongItTook) {
    begin();
    motion.planning_takes = 150;
    motion.wanted = true;
    reader.let_pass(1);
    advance();
    EXPECT_EQ(publisher.missed(), 0u);
    EXPECT_EQ(motion.lead_asked_for, 100u);  // twice 150, of which the ticks are 200 ahead
}

TEST_F(LatePlans, APlanThatComesTooLateIsTakenBackAndTheRowsGoOn) {
    begin();
    motion.planning_takes = 600;
    motion.wanted = true;
    reader.let_pass(1);
    advance();
    EXPECT_EQ(publisher.missed(), 1u);
    EXPECT_EQ(motion.taken_back, 1);
    EXPECT_EQ(motion.lead_asked_for, 1000u);
    reader.let_pass(100);
    EXPECT_FALSE(publisher.reader_stands());
    advance();
    motion.planning_takes = 0;
    motion.wanted = true;
    reader.let_pass(1);
    advance();
    EXPECT_EQ(publisher.missed(), 1u);
}

/// While one plan was made the reader went on: the next one has the whole lead again.
TEST_F(LatePlans, NothingIsPlannedBeforeTheTicksHaveTheLeadAgain) {
    begin();
    motion.planning_takes = 150;
    motion.wanted = true;
    reader.let_pass(1);
    advance();
    const int planned = motion.ticked_at_lead;
    const std::size_t at = motion.at();
    advance();
    EXPECT_EQ(motion.at(), at + 150);
    EXPECT_EQ(motion.ticked_at_lead, planned + 1);
}

}  // namespace
}  // namespace trunnion::test
