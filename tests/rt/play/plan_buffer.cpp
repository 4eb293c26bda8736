#include <memory>

#include <gtest/gtest.h>
#include <malloc.h>
#include <plan_buffer.h>

namespace trunnion::test {
namespace {

struct Buffer {
    std::unique_ptr<trunnion_plans> plans = std::make_unique<trunnion_plans>();
    trunnion_reader reader{};

    Buffer() {
        trunnion_plans_begin(plans.get(), 5, 1e-3);
        EXPECT_EQ(trunnion_reader_begin(&reader, plans.get()), 0);
    }
    /// Rows whose first position is their number, and `plan` the second.
    void fill(std::uint64_t first, std::uint64_t branch, std::uint64_t count, double plan) const {
        trunnion_plan* to = trunnion_plan_to_fill(plans.get());
        ASSERT_NE(to, nullptr);
        to->first = first;
        to->branch = branch;
        to->count = count;
        for (std::uint64_t k = 0; k < count; ++k) {
            to->rows[k].position[0] = static_cast<double>(first + k);
            to->rows[k].position[1] = plan;
        }
    }
    void publish(std::uint64_t first, std::uint64_t branch, std::uint64_t count, double plan) const {
        fill(first, branch, count, plan);
        trunnion_publish(plans.get());
    }
    /// Number of the row of the next period, −1 at a standstill; which plan it is of.
    std::pair<double, double> next() {
        trunnion_look(&reader);
        const trunnion_row* row = trunnion_next_row(&reader);
        return row ? std::pair(row->position[0], row->position[1]) : std::pair(-1.0, -1.0);
    }
};

using Row = std::pair<double, double>;
const Row standing(-1, -1);

TEST(PlanBuffer, PlaysAPlanToItsStandstill) {
    Buffer buffer;
    EXPECT_EQ(buffer.next(), standing);
    buffer.publish(0, 0, 3, 1);
    for (double row = 0; row < 3; ++row) EXPECT_EQ(buffer.next(), Row(row, 1));
    EXPECT_EQ(buffer.next(), standing);
    EXPECT_EQ(buffer.next(), standing);
    buffer.publish(3, 3, 1, 2);
    EXPECT_EQ(buffer.next(), Row(3, 2));
}

TEST(PlanBuffer, GoesOverToANewerPlanUpToItsBranch) {
    Buffer buffer;
    buffer.publish(0, 0, 10, 1);
    EXPECT_EQ(buffer.next(), Row(0, 1));
    EXPECT_EQ(buffer.next(), Row(1, 1));
    buffer.publish(1, 2, 10, 2);
    EXPECT_EQ(buffer.next(), Row(2, 2));
}

TEST(PlanBuffer, RefusesAPlanThatCameTooLate) {
    Buffer buffer;
    buffer.publish(0, 0, 6, 1);
    for (double row = 0; row < 4; ++row) EXPECT_EQ(buffer.next(), Row(row, 1));
    buffer.publish(0, 3, 10, 2);
    EXPECT_EQ(buffer.next(), Row(4, 1));
    EXPECT_EQ(buffer.plans->looked_at, 2u);
    EXPECT_EQ(buffer.plans->in_use, 1u);
    // The next one takes the place of the refused one.
    buffer.publish(5, 6, 5, 3);
    EXPECT_EQ(buffer.plans->published, 4u);
    EXPECT_EQ(buffer.next(), Row(5, 3));
    EXPECT_EQ(buffer.next(), Row(6, 3));
}

TEST(PlanBuffer, APlanWithoutTheNextRowIsRefused) {
    Buffer buffer;
    buffer.publish(0, 0, 6, 1);
    EXPECT_EQ(buffer.next(), Row(0, 1));
    buffer.publish(2, 5, 10, 2);
    EXPECT_EQ(buffer.next(), Row(1, 1));
}

TEST(PlanBuffer, WhatIsHalfFilledIsNotSeen) {
    Buffer buffer;
    buffer.publish(0, 0, 3, 1);
    EXPECT_EQ(buffer.next(), Row(0, 1));
    buffer.fill(0, 1, 3, 2);
    EXPECT_EQ(buffer.next(), Row(1, 1));
    EXPECT_EQ(buffer.next(), Row(2, 1));
    EXPECT_EQ(buffer.next(), standing);
}

TEST(PlanBuffer, TheWriterWaitsUntilTheReaderHasLooked) {
    const Buffer buffer;
    buffer.publish(0, 0, 3, 1);
    EXPECT_EQ(trunnion_plan_to_fill(buffer.plans.get()), nullptr);
}

TEST(PlanBuffer, OtherMemoryIsRefused) {
    const auto plans = std::make_unique<trunnion_plans>();
    trunnion_reader reader{};
    EXPECT_EQ(trunnion_reader_begin(&reader, plans.get()), -1);
    plans->format = TRUNNION_PLAN_FORMAT + 1;
    EXPECT_EQ(trunnion_reader_begin(&reader, plans.get()), -1);
}

TEST(PlanBuffer, ReadingDoesNotAllocate) {
    Buffer buffer;
    buffer.publish(0, 0, TRUNNION_PLAN_ROWS, 1);
    const auto before = mallinfo2();
    double sum = 0;
    for (int k = 0; k < TRUNNION_PLAN_ROWS + 100; ++k) {
        trunnion_look(&buffer.reader);
        const trunnion_row* row = trunnion_next_row(&buffer.reader);
        sum += row ? row->position[1] : 0;
    }
    const auto after = mallinfo2();
    EXPECT_EQ(sum, TRUNNION_PLAN_ROWS);
    EXPECT_EQ(after.uordblks, before.uordblks);
    EXPECT_EQ(after.hblks, before.hblks);
}

}  // namespace
}  // namespace trunnion::test
