// Curves in the dialects that have them: read(write(x)) = x for each form, and what a form cannot hold.
// TRUNNION_SEED replays one random program.
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/nc/write.hpp"

#include "curves.hpp"
#include "detail/curves.hpp"
#include "random.hpp"
#include "reading.hpp"

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;
using program::Curve;
using program::FeedRule;
using program::Move;
using program::OrientationLaw;
using program::Program;
using program::Space;

/// What the curves of a random program are like.
struct Likeness {
    int degree = 3;
    OrientationLaw law = OrientationLaw::rotary;
    bool turning = false;  ///< control values or vectors
    bool rational = false;
    bool clamped = true;
    bool changing = false;  ///< feeds, events and exact stops along a curve
};

/// A start, curves with a straight move between some of them; as readers make them.
class CurveMaker {
  public:
    CurveMaker(std::uint64_t seed, Likeness like) : random_{seed * 0x9E3779B97F4A7C15u + 1}, like_(like) {}

    Program operator()(Dialect dialect) {
        program_.dialect = name_of(dialect);
        if (like_.law == OrientationLaw::rotary) program_.rotary_letters = {'A', 'C'};
        if (dialect == Dialect::fanuc) program_.offsets = {"", "G54"};
        at_.offset = dialect == Dialect::fanuc ? 1 : 0;
        at_.law = like_.law;
        at_.feed = {FeedRule::tip_speed, 10};
        program_.moves.push_back(at_);
        for (int k = 0; k < 3; ++k) {
            curve();
            if (chance(0.5)) straight();
        }
        return std::move(program_);
    }

  private:
    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(random_.below(1u << 30)) / (1u << 30);
    }
    bool chance(double p) { return between(0, 1) < p; }
    Vector3d step(double most) {
        const double x = between(1, most), y = between(-most, most), z = between(-most, most);
        return {x, y, z};
    }

    void straight() {
        at_.position_mm += step(10);
        at_.curve_part = program::no_curve_part;
        at_.line += 1;
        program_.moves.push_back(at_);
    }

    std::vector<double> knots(std::size_t points) {
        const auto p = static_cast<std::size_t>(like_.degree);
        std::vector<double> out;
        double u = like_.clamped ? 0 : between(-3, 3);
        for (std::size_t i = 0; i < points + p + 1; ++i) {
            const bool at_end = i <= p || i > points;
            if (i > 0 && !(like_.clamped && at_end)) u += between(0.3, 9);
            if (like_.clamped && i == points) u += between(0.3, 9);
            out.push_back(u);
        }
        return out;
    }

    /// From where the tool stands; with an unclamped one the whole curve is moved there.
    void curve() {
        const std::size_t points = static_cast<std::size_t>(like_.degree) + 1 + random_.below(4);
        Curve curve;
        curve.degree = like_.degree;
        curve.knots = knots(points);
        for (std::size_t i = 0; i < points; ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(points);
            curve.position_mm.emplace_back(i == 0 ? at_.position_mm : Vector3d(curve.position_mm.back() + step(8)));
            if (like_.rational) curve.weights.push_back(i == 0 ? 1 : between(0.4, 2.5));
            if (!like_.turning) continue;
            const double turn = between(-0.2, 0.2), other = between(-0.2, 0.2);
            if (like_.law == OrientationLaw::rotary)
                curve.rotary_rad.push_back(
                    {at_.rotary_rad[0] + share * turn, at_.rotary_rad[1] + 3 * share * other, 0});
            else
                curve.axis.emplace_back(axis_ + share * Vector3d(turn, other, 0.3 * turn));
        }
        put(std::move(curve));
    }

    void put(Curve curve) {
        const auto p = static_cast<std::size_t>(like_.degree);
        if (!like_.clamped) move_to_start(curve);
        const auto index = static_cast<std::int32_t>(program_.curves.size());
        for (std::size_t k = p; k < curve.position_mm.size(); ++k) {
            const CurvePose end = pose_at(curve, curve.knots[k + 1]);
            at_.position_mm = end.position_mm;
            if (!curve.axis.empty()) at_.axis = end.axis.normalized();
            if (!curve.axis.empty()) axis_ = end.axis;
            if (!curve.rotary_rad.empty()) at_.rotary_rad = end.rotary_rad;
            at_.line += 1;
            if (like_.changing && chance(0.3)) at_.feed.value = between(1, 100);
            if (like_.changing && chance(0.2))
                program_.events.push_back({program::EventKind::dwell, true, 0.5, {}, program_.moves.size(), 0});
            Move move = at_;
            move.exact_stop = like_.changing && chance(0.2);
            follow_curve(program_, move, {index, curve.knots[k], curve.knots[k + 1]});
            program_.moves.push_back(move);
        }
        program_.curves.push_back(std::move(curve));
    }

    void move_to_start(Curve& curve) const {
        const auto p = static_cast<std::size_t>(like_.degree);
        const CurvePose start = pose_at(curve, curve.knots[p]);
        for (Vector3d& point : curve.position_mm) point += at_.position_mm - start.position_mm;
        for (auto& words : curve.rotary_rad)
            for (std::size_t i = 0; i < words.size(); ++i) words[i] += at_.rotary_rad[i] - start.rotary_rad[i];
        for (Vector3d& axis : curve.axis) axis += axis_ - start.axis;
    }

    Random random_;
    Likeness like_;
    Program program_;
    Move at_;
    Vector3d axis_ = Vector3d::UnitZ();  ///< of the curve, not unit
};

/// Where a move of a curve is after a share of its parameter.
CurvePose pose_along(const Program& program, const Move& move, double share) {
    const program::CurvePart& part = part_of(program, move);
    return pose_at(curve_of(program, move), part.from_u + share * (part.to_u - part.from_u));
}

void expect_same_way(const Program& program, std::size_t k, const Program& read, const WriteOptions& options) {
    const Move &a = program.moves[k], &b = read.moves[k];
    for (const double share : {0.1, 0.35, 0.5, 0.8, 1.0}) {
        const CurvePose x = pose_along(program, a, share), y = pose_along(read, b, share);
        EXPECT_LE((x.position_mm - y.position_mm).cwiseAbs().maxCoeff(), 2.5 * options.precision_mm) << share;
        if (!curve_of(program, a).axis.empty()) {
            EXPECT_LE((x.axis.normalized() - y.axis.normalized()).norm(), 5e-6) << share;
        }
        if (curve_of(program, a).rotary_rad.empty()) continue;
        for (std::size_t i = 0; i < 2; ++i)
            EXPECT_NEAR(x.rotary_rad[i], y.rotary_rad[i], 2.5 * options.precision_deg * degree) << share;
    }
}

void expect_same_moves(const Program& program, const Program& read, const WriteOptions& options) {
    ASSERT_EQ(read.moves.size(), program.moves.size());
    ASSERT_GE(read.events.size(), program.events.size());  // and M30
    for (std::size_t k = 0; k < program.events.size(); ++k)
        EXPECT_EQ(read.events[k].before_move, program.events[k].before_move);
    for (std::size_t k = 1; k < program.moves.size(); ++k) {
        SCOPED_TRACE(testing::Message() << "move " << k);
        const Move &a = program.moves[k], &b = read.moves[k];
        EXPECT_LE((a.position_mm - b.position_mm).cwiseAbs().maxCoeff(), 2 * options.precision_mm);
        EXPECT_NEAR(a.feed.value, b.feed.value, 2e-6 * a.feed.value);
        EXPECT_EQ(a.exact_stop, b.exact_stop);
        EXPECT_EQ(a.law, b.law);
        const bool along_a = a.curve_part != program::no_curve_part, along_b = b.curve_part != program::no_curve_part;
        ASSERT_EQ(along_a, along_b);
        if (along_a) expect_same_way(program, k, read, options);
    }
}

std::size_t count_of(std::string_view text, std::string_view word) {
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) ++count;
    return count;
}

/// As the form that is asked for, whose word stands in the text.
void round_trips(Dialect dialect, CurveForm form, const Likeness& like, std::string_view word,
                 Units units = Units::mm) {
    const char* const replay = std::getenv("TRUNNION_SEED");
    const std::uint64_t first = replay ? std::strtoull(replay, nullptr, 10) : 1, count = replay ? 1 : 25;
    const machine::Machine machine = machine_with("AC");
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        SCOPED_TRACE(testing::Message() << "TRUNNION_SEED=" << seed);
        const Program program = CurveMaker(seed, like)(dialect);
        WriteOptions options;
        options.dialect = dialect;
        options.curves = form;
        options.units = units;
        const auto text = write_text(program, &machine, options);
        ASSERT_TRUE(text) << to_string(text.error());
        SCOPED_TRACE(*text);
        EXPECT_GT(count_of(*text, word), 0u);
        const auto read = read_with(machine, *text);
        ASSERT_TRUE(read) << said(read);
        ASSERT_EQ(read->dialect, name_of(dialect));
        expect_sound_curves(*read);
        expect_same_moves(program, *read, options);
        if (testing::Test::HasFailure()) return;
    }
}

constexpr auto words = OrientationLaw::rotary, vectors = OrientationLaw::vector;

TEST(WriteCurves, bspline_of_every_degree) {
    for (const int degree : {1, 2, 3})
        for (const bool turning : {false, true})
            for (const OrientationLaw law : {words, vectors})
                round_trips(Dialect::sinumerik, CurveForm::bspline, {degree, law, turning}, "BSPLINE");
}
TEST(WriteCurves, bspline_with_weights) {
    for (const OrientationLaw law : {words, vectors})
        round_trips(Dialect::sinumerik, CurveForm::bspline, {3, law, true, true}, "PW=");
}
TEST(WriteCurves, poly_of_every_degree) {
    for (const int degree : {2, 3, 4, 5})
        for (const bool clamped : {true, false})
            round_trips(Dialect::sinumerik, CurveForm::poly, {degree, words, false, false, clamped}, "PO[X]");
}
TEST(WriteCurves, poly_of_rotary_words) {
    round_trips(Dialect::sinumerik, CurveForm::poly, {3, words, true}, "PO[C]");
    round_trips(Dialect::sinumerik, CurveForm::poly, {5, words, true, false, false, true}, "PO[A]", Units::inch);
}
TEST(WriteCurves, poly_of_a_second_curve) {
    round_trips(Dialect::sinumerik, CurveForm::poly, {3, vectors, true}, "PO[ZH]");
    round_trips(Dialect::sinumerik, CurveForm::poly, {4, vectors, true, false, false}, "PO[XH]", Units::inch);
}
TEST(WriteCurves, poly_with_a_denominator) {
    round_trips(Dialect::sinumerik, CurveForm::poly, {2, words, false, true}, "PO[]=");
    round_trips(Dialect::sinumerik, CurveForm::poly, {3, vectors, false, true, false}, "PO[]=");
}
TEST(WriteCurves, poly_with_events_feeds_and_stops) {
    round_trips(Dialect::sinumerik, CurveForm::poly, {3, words, true, false, true, true}, "PO[X]");
}
/// BSPLINE where it can, POLY where a curve is interrupted.
TEST(WriteCurves, sinumerik_chooses) {
    round_trips(Dialect::sinumerik, CurveForm::own, {3, words, true, false, true, true}, "PL=");
    round_trips(Dialect::sinumerik, CurveForm::own, {4, vectors, true}, "PO[X]");
    round_trips(Dialect::sinumerik, CurveForm::own, {3, vectors, true, false, true}, "PL=", Units::inch);
}
TEST(WriteCurves, nurbs_of_every_degree) {
    for (const int degree : {1, 2, 3})
        for (const bool turning : {false, true})
            for (const bool clamped : {true, false})
                round_trips(Dialect::fanuc, CurveForm::nurbs, {degree, words, turning, false, clamped}, "G06.2");
}
TEST(WriteCurves, nurbs_with_weights) {
    round_trips(Dialect::fanuc, CurveForm::nurbs, {3, words, true, true}, " R");
    round_trips(Dialect::fanuc, CurveForm::own, {2, words, false, true, false}, " R", Units::inch);
}
TEST(WriteCurves, nurbs_with_events_feeds_and_stops) {
    round_trips(Dialect::fanuc, CurveForm::nurbs, {3, words, true, false, true, true}, "G06.2");
}

/// Whose control points are the corners of a square, and its ends.
Program one_curve(OrientationLaw law, int degree = 3) {
    Program program;
    program.dialect = "sinumerik";
    Move move;
    move.law = law;
    program.moves.push_back(move);
    Curve curve;
    curve.degree = degree;
    for (const Vector3d& point : {Vector3d(0, 0, 0), Vector3d(6, 0, 0), Vector3d(6, 6, 0), Vector3d(0, 6, 3)})
        curve.position_mm.push_back(point);
    while (curve.position_mm.size() <= static_cast<std::size_t>(degree))
        curve.position_mm.emplace_back(curve.position_mm.back() + Vector3d(1, 0, 0));
    curve.knots = clamped_knots(degree, std::vector<double>(curve.position_mm.size() - std::size_t(degree), 2.0));
    move.position_mm = curve.position_mm.back();
    move.feed = {FeedRule::tip_speed, 10};
    follow_curve(program, move, {0, curve.knots.front(), curve.knots.back()});
    program.moves.push_back(move);
    program.curves = {curve};
    return program;
}

std::string written(const Program& program, Dialect dialect, CurveForm form = CurveForm::own) {
    WriteOptions options;
    options.dialect = dialect;
    options.curves = form;
    const auto text = write_text(program, nullptr, options);
    return text ? *text : text.error().code;
}

TEST(WriteCurves, word_by_word) {
    const Program cubic = one_curve(words);
    EXPECT_NE(written(cubic, Dialect::sinumerik, CurveForm::poly)
                  .find("POLY PO[X]=(0,-18) PO[Y]=(6,18,-12) PO[Z]=(3,0,3) F600\n"),
              std::string::npos)
        << written(cubic, Dialect::sinumerik, CurveForm::poly);
    EXPECT_NE(written(cubic, Dialect::fanuc)
                  .find("G06.2 P4. K0. X0. Y0. Z0. F600.\nK0. X6. Y0. Z0.\nK0. X6. Y6. Z0.\nK0. X0. Y6. Z3.\n"
                        "K2.\nK2.\nK2.\nK2.\nM30"),
              std::string::npos)
        << written(cubic, Dialect::fanuc);
}

/// Divided, and told, where the dialect chooses; refused where one form is asked for.
TEST(WriteCurves, what_does_not_fit) {
    const Program by_vectors = one_curve(vectors), of_degree_6 = one_curve(words, 6);
    Program timed = one_curve(words), bent = one_curve(words);
    timed.moves[1].feed = {FeedRule::block_time, 2};
    bent.rotary_letters = {'A'};
    bent.curves[0].weights = {1, 1, 2, 1};
    bent.moves[1].rotary_rad[0] = 0.1;
    Program rational_turn = bent;
    for (int i = 0; i < 4; ++i) rational_turn.curves[0].rotary_rad.push_back({0.1 * i / 3, 0, 0});
    for (const Program& program : {by_vectors, of_degree_6, timed, bent}) {
        EXPECT_EQ(written(program, Dialect::fanuc, CurveForm::nurbs), "NC0909");
        EXPECT_EQ(count_of(written(program, Dialect::fanuc), "G06.2"), 0u);
        EXPECT_GT(count_of(written(program, Dialect::fanuc), "X"), 20u);
    }
    EXPECT_EQ(written(of_degree_6, Dialect::sinumerik, CurveForm::poly), "NC0909");
    EXPECT_EQ(written(rational_turn, Dialect::sinumerik, CurveForm::poly), "NC0909");
    EXPECT_EQ(written(one_curve(words, 4), Dialect::sinumerik, CurveForm::bspline), "NC0909");
    EXPECT_EQ(written(bent, Dialect::sinumerik, CurveForm::bspline), "NC0909");
    EXPECT_EQ(count_of(written(bent, Dialect::sinumerik), "PO[]="), 1u);
    EXPECT_EQ(count_of(written(of_degree_6, Dialect::sinumerik), "PO["), 0u);
    EXPECT_GT(count_of(written(one_curve(words), Dialect::sinumerik, CurveForm::points), "X"), 20u);
}

TEST(WriteCurves, a_form_of_another_dialect) {
    const Program program = one_curve(words);
    EXPECT_EQ(written(program, Dialect::fanuc, CurveForm::bspline), "NC0908");
    EXPECT_EQ(written(program, Dialect::sinumerik, CurveForm::nurbs), "NC0908");
    EXPECT_EQ(written(program, Dialect::rs274, CurveForm::poly), "NC0908");
}

/// Linear in the parameter along one polynomial: NURBS and POLY say it, a rational NURBS cannot.
TEST(WriteCurves, words_that_turn_evenly) {
    Program program = one_curve(words);
    program.rotary_letters = {'A', 'C'};
    program.offsets = {"", "G54"};
    for (Move& move : program.moves) move.offset = 1;
    program.moves[1].rotary_rad = {0.2, -0.3, 0};
    const std::string text = written(program, Dialect::fanuc, CurveForm::nurbs);
    const auto read = read_ac(text);
    ASSERT_TRUE(read) << said(read) << text;
    for (const double share : {0.25, 0.5, 0.9}) {
        const CurvePose pose = pose_along(*read, read->moves[1], share);
        EXPECT_NEAR(pose.rotary_rad[0], 0.2 * share, 1e-8);
        EXPECT_NEAR(pose.rotary_rad[1], -0.3 * share, 1e-8);
    }
}

/// A part of a curve is the curve there, whatever its ends.
TEST(WriteCurves, parts_of_curves) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Program program = CurveMaker(seed, {3, words, true, true, false})(Dialect::sinumerik);
        const Curve& curve = program.curves[0];
        const double begin = curve.knots[3], end = curve.knots[curve.position_mm.size()];
        const double from = begin + 0.2 * (end - begin), to = begin + 0.9 * (end - begin);
        const Curve part = part_of_curve(curve, from, to);
        EXPECT_EQ(part.knots.front(), 0);
        EXPECT_NEAR(part.weights.front(), 1, 1e-12);
        for (const double share : {0.0, 0.1, 0.5, 0.77, 1.0}) {
            const double u = share * part.knots.back();
            const CurvePose a = pose_at(curve, from + u), b = pose_at(part, u);
            EXPECT_LT((a.position_mm - b.position_mm).norm(), 1e-10) << seed;
            EXPECT_LT((Vector3d(a.rotary_rad.data()) - Vector3d(b.rotary_rad.data())).norm(), 1e-11) << seed;
        }
    }
}

TEST(WriteCurves, coefficients_and_ordinates) {
    const std::vector<double> coefficients{1, -2, 0.5, 4};
    const std::vector<double> back = power_coefficients(bernstein_ordinates(coefficients));
    for (std::size_t i = 0; i < back.size(); ++i) EXPECT_NEAR(back[i], coefficients[i], 1e-12);
}

}  // namespace
}  // namespace trunnion::nc
