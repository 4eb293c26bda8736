#include <gtest/gtest.h>

#include "made_motions.hpp"

/// Words that leave the pose of the tool unchanged: C at A0.
namespace trunnion::verify::test {
namespace {

/// Rows with C as a function of the share of a way of 20 mm along X, A at 0.
template <class Angle>
SetpointTable along_x(Angle c, int count = 2000) {
    std::vector<motion::Setpoint> rows;
    for (int n = 0; n <= count; ++n) {
        const double w = static_cast<double>(n) / count;
        rows.push_back(row(rows.size(), axes_for({20 * w, 0, 0}, 0, c(w))));
    }
    return *setpoint_table(std::move(rows));
}

/// C from 0 to 90° and back, poses every 5 mm.
std::vector<ProgrammedPose> there_and_back() {
    std::vector<ProgrammedPose> out;
    for (int n = 0; n <= 4; ++n)
        out.push_back(pose_by_words({5.0 * n, 0, 0}, 0, (n <= 2 ? n : 4 - n) * 45 * degree, n));
    for (auto& pose : out) pose.literal = true;
    out.front().stands = out.back().stands = true;
    return out;
}

double triangle(double w) {
    return 180 * degree * std::min(w, 1 - w);
}

Verdict verdict_of(const SetpointTable& motion, const std::vector<ProgrammedPose>& poses, CheckOptions options = {}) {
    auto verdict = check(motion, poses, boundless(), peer_setup(), options);
    EXPECT_TRUE(verdict) << (verdict ? "" : to_string(verdict.error()));
    return verdict.value_or(Verdict{});
}

/// Without limits that matter the jerk would allow anything within half a period.
Verdict strict_verdict_of(const SetpointTable& motion, const std::vector<ProgrammedPose>& poses) {
    auto machine = boundless();
    machine.axes[3].feed.jerk = machine.axes[4].feed.jerk = machine.axes[3].rapid.jerk = machine.axes[4].rapid.jerk =
        1800 * degree;
    auto verdict = check(motion, poses, machine, peer_setup(), {});
    return verdict.value_or(Verdict{});
}

TEST(RotaryWords, AreSeenThoughThePoseIsTheSame) {
    EXPECT_TRUE(verdict_of(along_x(triangle), there_and_back()).ok);
    const auto v = verdict_of(along_x([](double) { return 0.0; }), there_and_back());
    EXPECT_TRUE(only_broken(v, {"words_on_the_way_deg"})) << broken_things(v);
    EXPECT_EQ(v.first_of("words_on_the_way_deg")->line, 1);
    EXPECT_NEAR(v.words_on_the_way_deg, 45, 1e-9);
    EXPECT_NEAR(v.first_of("words_on_the_way_deg")->limit, 5, 1e-5);  // 0.1° / 0.02
    auto vectors = there_and_back();
    for (auto& pose : vectors) pose.literal = false;
    EXPECT_TRUE(verdict_of(along_x([](double) { return 0.0; }), vectors).ok);
}

TEST(RotaryWords, MayBeRoundedOnTheWay) {
    const auto cut = [](double top) { return [top](double w) { return std::min(triangle(w), top * degree); }; };
    EXPECT_TRUE(verdict_of(along_x(cut(86)), there_and_back()).ok);
    EXPECT_NEAR(verdict_of(along_x(cut(86)), there_and_back()).words_on_the_way_deg, 4, 1e-9);
    EXPECT_FALSE(verdict_of(along_x(cut(84)), there_and_back()).ok);
    CheckOptions narrow;
    narrow.orientation_tolerance_rad = 0.05 * degree;
    EXPECT_FALSE(verdict_of(along_x(cut(86)), there_and_back(), narrow).ok);
    CheckOptions flank;
    flank.flank_tolerance_mm = 30 * 0.05 * degree;
    EXPECT_FALSE(verdict_of(along_x(cut(86)), there_and_back(), flank).ok);
    flank.flank_tolerance_mm *= 2;
    EXPECT_TRUE(verdict_of(along_x(cut(86)), there_and_back(), flank).ok);
}

TEST(RotaryWords, AreExactWhereTheProgramStops) {
    auto poses = there_and_back();
    poses[2].stands = true;
    const auto cut = [](double w) { return std::min(triangle(w), 89.9 * degree); };
    EXPECT_FALSE(strict_verdict_of(along_x(triangle), poses).first_of("words_at_stops_deg"));
    EXPECT_LT(strict_verdict_of(along_x(triangle), poses).words_at_stops_deg, 1e-9);
    auto v = strict_verdict_of(along_x(cut), poses);
    EXPECT_TRUE(v.first_of("words_at_stops_deg")) << broken_things(v);
    EXPECT_NEAR(v.words_at_stops_deg, 0.1, 1e-9);
    EXPECT_EQ(v.first_of("words_at_stops_deg")->line, 2);
    EXPECT_NEAR(v.first_of("words_at_stops_deg")->limit, 1e-6 + 1.001 * 1800 / 48 * 1e-9, 1e-9);
    poses[2].stands = false;
    v = strict_verdict_of(along_x(cut), poses);
    EXPECT_FALSE(v.first_of("words_at_stops_deg")) << broken_things(v);
}

TEST(RotaryWords, FirstAndLastRowStandAtTheirs) {
    auto late = [](double w) { return w == 0 ? 2e-5 * degree : triangle(w); };
    EXPECT_TRUE(strict_verdict_of(along_x(late), there_and_back()).first_of("words_at_stops_deg"));
    auto other = [](double w) { return w < 0.9 ? triangle(w) : 18 * degree - (w - 0.9) * 3780 * degree; };
    const auto v = strict_verdict_of(along_x(other), there_and_back());  // a turn more: the pose is the same
    ASSERT_TRUE(v.first_of("words_at_stops_deg")) << broken_things(v);
    EXPECT_NEAR(v.words_at_stops_deg, 360, 1e-6);
}

/// The tip stands, C goes there and back: only the order of the words says how.
TEST(RotaryWords, AreFoundInOrderWhereTheTipStands) {
    const auto poses_with = [](std::initializer_list<double> degrees) {
        std::vector<ProgrammedPose> out;
        for (const double c : degrees) {
            out.push_back(pose_by_words({1, 2, 3}, 0, c * degree, static_cast<std::int32_t>(out.size())));
            out.back().literal = true;
        }
        return out;
    };
    const auto motion_with = [](std::initializer_list<double> degrees) {
        std::vector<motion::Setpoint> rows;
        double last = *degrees.begin();
        for (const double c : degrees) {
            for (int n = 1; n <= 100; ++n)
                rows.push_back(row(rows.size(), axes_for({1, 2, 3}, 0, (last + n * (c - last) / 100) * degree)));
            last = c;
        }
        return *setpoint_table(std::move(rows));
    };
    EXPECT_TRUE(verdict_of(motion_with({0, 360, 0, 90}), poses_with({0, 360, 0, 90})).ok);
    const auto once = verdict_of(motion_with({0, 360, 90}), poses_with({0, 360, 0, 90}));
    EXPECT_TRUE(only_broken(once, {"words_on_the_way_deg"})) << broken_things(once);
    EXPECT_EQ(once.first_of("words_on_the_way_deg")->line, 2);
    EXPECT_NEAR(once.words_on_the_way_deg, 90, 1e-9);
    EXPECT_FALSE(verdict_of(motion_with({0, 90}), poses_with({0, 360, 0, 90})).ok);
}

}  // namespace
}  // namespace trunnion::verify::test
