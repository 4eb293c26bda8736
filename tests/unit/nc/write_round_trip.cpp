// read(write(x)) = x: random programs in every dialect. TRUNNION_SEED replays one, TRUNNION_PROGRAMS sets how
// many.
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/helix.hpp"
#include "trunnion/nc/write.hpp"

#include "detail/action_writer.hpp"
#include "detail/curves.hpp"
#include "random.hpp"
#include "reading.hpp"

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Program;
using program::Space;

/// Random programs as readers make them: every move goes somewhere.
class Maker {
  public:
    explicit Maker(std::uint64_t seed) : random_{seed * 0x9E3779B97F4A7C15u + 1} {}

    Program operator()(Dialect dialect, bool vectors) {
        program_.dialect = name_of(dialect);
        program_.name = "RANDOM";
        if (!vectors) program_.rotary_letters = {'A', 'C'};
        const bool always_offset = dialect == Dialect::rs274 || dialect == Dialect::fanuc;
        if (always_offset) program_.offsets = {"", "G54"};
        at_.offset = always_offset ? 1 : 0;
        at_.law = vectors ? OrientationLaw::vector : OrientationLaw::rotary;
        at_.feed = {FeedRule::tip_speed, 10};
        program_.moves.push_back(at_);
        const std::size_t count = 5 + random_.below(60);
        for (std::size_t k = 0; k < count; ++k) step(dialect);
        return std::move(program_);
    }

  private:
    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(random_.below(1u << 30)) / (1u << 30);
    }
    bool chance(double p) { return between(0, 1) < p; }
    Vector3d direction() {
        const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        return Vector3d(x, y, z + 1e-3).normalized();
    }

    void step(Dialect dialect) {
        const bool in_workpiece = dialect == Dialect::apt || !chance(0.1) || at_.law == OrientationLaw::vector;
        const Vector3d start = at_.position_mm;
        const bool same_space = at_.space == Space::workpiece && in_workpiece;
        at_.space = in_workpiece ? Space::workpiece : Space::untransformed;
        at_.kind = chance(0.1) ? MoveKind::rapid : MoveKind::feed;
        at_.line = static_cast<std::int32_t>(program_.moves.size()) + 1;
        at_.arc = program::no_arc;
        at_.exact_stop = dialect != Dialect::apt && dialect != Dialect::heidenhain && chance(0.1);
        at_.position_mm += between(0.01, 30) * direction();
        turn();
        if (chance(0.3)) at_.feed.value = between(0.5, 300);
        const bool has_arcs = dialect == Dialect::rs274 || dialect == Dialect::sinumerik || dialect == Dialect::apt;
        if (has_arcs && same_space && at_.kind == MoveKind::feed && chance(0.3)) arc(start, dialect);
        Move move = at_;
        if (dialect != Dialect::apt && dialect != Dialect::heidenhain && chance(0.1))
            move.feed = {FeedRule::block_time, between(0.01, 2)};
        if (move.kind == MoveKind::rapid) move.feed = {};
        if (chance(0.05))
            program_.events.push_back(
                {program::EventKind::dwell, true, between(0.01, 2), {}, program_.moves.size(), 0});
        program_.moves.push_back(move);
    }

    void turn() {
        if (at_.law == OrientationLaw::vector) {
            if (chance(0.8)) at_.axis = (at_.axis + 0.2 * direction() + Vector3d(0, 0, 0.1)).normalized();
            return;
        }
        if (chance(0.7)) at_.rotary_rad[0] += between(-0.1, 0.1);
        if (chance(0.7)) at_.rotary_rad[1] += between(-0.5, 0.5);
    }

    /// In a plane, in apt and sinumerik now and then about any direction, with further turns where they can be said.
    void arc(const Vector3d& start, Dialect dialect) {
        Vector3d normal = Vector3d::Unit(static_cast<Eigen::Index>(random_.below(3)));
        const bool in_space = dialect == Dialect::sinumerik || dialect == Dialect::apt;
        if (in_space && chance(0.3)) normal = direction();
        const bool in_plane = normal.cwiseAbs().maxCoeff() == 1;
        if (chance(0.5)) normal = -normal;
        Vector3d arm = direction().cross(normal);
        if (arm.norm() < 0.1) return;
        arm *= between(1, 50) / arm.norm();
        // Three points that are written say a circle in space badly where its ends are close.
        double angle = (in_plane ? between(0.05, 6.2) : between(0.3, 4.5)) * (chance(0.5) ? 1 : -1);
        if (in_plane && chance(0.2)) angle += std::copysign(4 * std::numbers::pi, angle);
        at_.arc = static_cast<std::int32_t>(program_.arcs.size());
        program_.arcs.push_back({start - arm, normal, angle});
        at_.position_mm = start - arm + Eigen::AngleAxisd(angle, normal) * arm;
        if (in_plane && chance(0.4)) at_.position_mm += between(-5, 5) * normal;
    }

    Random random_;
    Program program_;
    Move at_;
};

/// Within a few steps of the precision, which a centre and an angle take part in.
void expect_same(const Program& program, const Program& read, const WriteOptions& options, std::uint64_t seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << " as " << program.dialect);
    const double slack = 1.01 * options.precision_mm;
    ASSERT_EQ(read.moves.size(), program.moves.size());
    ASSERT_GE(read.events.size(), program.events.size());
    for (std::size_t k = 0; k < program.moves.size(); ++k) {
        const Move &a = program.moves[k], &b = read.moves[k];
        SCOPED_TRACE(testing::Message() << "move " << k);
        EXPECT_LE((a.position_mm - b.position_mm).cwiseAbs().maxCoeff(), slack);
        ASSERT_EQ(a.law, b.law);
        ASSERT_EQ(a.space, b.space);
        if (a.law == OrientationLaw::vector) {
            EXPECT_LE((a.axis - b.axis).norm(), 3 * options.vector_precision);
        } else {
            for (std::size_t i = 0; i < program.rotary_letters.size(); ++i)
                EXPECT_NEAR(a.rotary_rad[i], b.rotary_rad[i], 1.01 * options.precision_deg * degree);
        }
        ASSERT_EQ(a.arc == program::no_arc, b.arc == program::no_arc);
        if (a.arc != program::no_arc) {
            const program::Arc& x = program.arcs[static_cast<std::size_t>(a.arc)];
            const program::Arc& y = read.arcs[static_cast<std::size_t>(b.arc)];
            const geometry::Helix written(read.moves[k - 1].position_mm, b.position_mm, y.centre_mm, y.normal,
                                          y.angle_rad);
            const geometry::Helix programmed(program.moves[k - 1].position_mm, a.position_mm, x.centre_mm, x.normal,
                                             x.angle_rad);
            for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9})
                EXPECT_LE((written.at(share) - programmed.at(share)).norm(), 5 * slack);
        }
        if (k == 0) continue;  // where motion starts: reached by a rapid
        ASSERT_EQ(a.kind, b.kind);
        EXPECT_EQ(a.feed.rule, b.feed.rule);
        EXPECT_NEAR(a.feed.value, b.feed.value, 2e-6 * a.feed.value);
        EXPECT_EQ(a.exact_stop, b.exact_stop);
    }
    for (std::size_t k = 0; k < program.events.size(); ++k) {
        EXPECT_EQ(program.events[k].before_move, read.events[k].before_move);
        EXPECT_NEAR(program.events[k].dwell_s, read.events[k].dwell_s, 2e-6);
    }
}

void round_trips(Dialect dialect, bool vectors, Units units = Units::mm) {
    const char *replay = std::getenv("TRUNNION_SEED"), *more = std::getenv("TRUNNION_PROGRAMS");
    const std::uint64_t first = replay ? std::strtoull(replay, nullptr, 10) : 1;
    const std::uint64_t count = more ? std::strtoull(more, nullptr, 10) : replay ? 1 : 60;
    const machine::Machine machine = machine_with("AC");
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        const Program program = Maker(seed)(dialect, vectors);
        WriteOptions options;
        options.dialect = dialect;
        options.units = units;
        const auto text = write_text(program, &machine, options);
        ASSERT_TRUE(text) << "seed " << seed << ": " << to_string(text.error());
        const auto read = read_with(machine, *text);
        ASSERT_TRUE(read) << "seed " << seed << ": " << said(read) << "\n" << *text;
        ASSERT_EQ(read->dialect, name_of(dialect)) << "seed " << seed;
        expect_same(program, *read, options, seed);
        if (testing::Test::HasFailure()) return;
    }
}

TEST(WriteRoundTrip, rs274) {
    round_trips(Dialect::rs274, false);
}
TEST(WriteRoundTrip, rs274_in_inches) {
    round_trips(Dialect::rs274, false, Units::inch);
}
TEST(WriteRoundTrip, sinumerik_rotary_words) {
    round_trips(Dialect::sinumerik, false);
}
TEST(WriteRoundTrip, sinumerik_vectors) {
    round_trips(Dialect::sinumerik, true);
}
TEST(WriteRoundTrip, apt) {
    round_trips(Dialect::apt, true);
}
TEST(WriteRoundTrip, heidenhain_rotary_words) {
    round_trips(Dialect::heidenhain, false);
}
TEST(WriteRoundTrip, heidenhain_vectors) {
    round_trips(Dialect::heidenhain, true);
}
TEST(WriteRoundTrip, fanuc_rotary_words) {
    round_trips(Dialect::fanuc, false);
}
TEST(WriteRoundTrip, fanuc_vectors) {
    round_trips(Dialect::fanuc, true);
}

/// What the events of a program ask for, tools as they are called at last.
std::vector<Action::Kind> asked(const Program& program) {
    std::vector<Action::Kind> out;
    for (const program::Event& event : program.events)
        for (const Action& action : actions_of(event))
            if (action.kind != Action::Kind::prepare_tool) out.push_back(action.kind);
    return out;
}

TEST(WriteRoundTrip, events_from_dialect_to_dialect) {
    const machine::Machine machine = machine_with("AC");
    const auto program = read_with(machine,
                                   "G21 G54 T3 M6\nS500 M3\nM8\nG0 X0 Y0 Z0\nG1 X1 F60\nG4 P0.5\nX2\nM5\nM9\nM1\nX3\n"
                                   "M30\n");
    ASSERT_TRUE(program) << said(program);
    for (const Dialect dialect :
         {Dialect::rs274, Dialect::sinumerik, Dialect::heidenhain, Dialect::fanuc, Dialect::apt}) {
        WriteOptions options;
        options.dialect = dialect;
        Program source = *program;
        if (dialect == Dialect::apt) source.rotary_letters.clear();
        const auto text = write_text(source, &machine, options);
        ASSERT_TRUE(text) << name_of(dialect) << ": " << to_string(text.error());
        const auto read = read_with(machine, *text);
        ASSERT_TRUE(read) << name_of(dialect) << ": " << said(read) << "\n" << *text;
        EXPECT_EQ(asked(*read), asked(*program)) << *text;
        ASSERT_EQ(read->moves.size(), program->moves.size()) << *text;
        EXPECT_EQ(read->tools[read->moves[1].tool], "3") << *text;
    }
}

/// A spline of tip and tool, by vectors or by words: the same at every place.
void curve_round_trip(OrientationLaw law) {
    const bool vectors = law == OrientationLaw::vector;
    Program program;
    if (!vectors) program.rotary_letters = {'A', 'C'};
    program.dialect = "sinumerik";
    program::Curve curve;
    curve.knots = {0, 0, 0, 0, 2, 5, 5, 5, 5};
    for (int i = 0; i < 5; ++i) {
        curve.position_mm.emplace_back(10 * i, 3 * i * i, 1);
        if (vectors) curve.axis.emplace_back(0.1 * i, 0.05 * i * i, 1 + 0.02 * i);
        if (!vectors) curve.rotary_rad.push_back({0.1 * i, 0.3 * i * i, 0});
    }
    Move start;
    start.law = law;
    start.position_mm = curve.position_mm.front();
    program.moves.push_back(start);
    program.curves = {curve};
    program.curve_parts = {{0, 0, 2}, {0, 2, 5}};
    for (int part = 0; part < 2; ++part) {
        Move move = start;
        const CurvePose end = pose_at(curve, program.curve_parts[static_cast<std::size_t>(part)].to_u);
        move.position_mm = end.position_mm;
        if (vectors) move.axis = end.axis.normalized();
        if (!vectors) move.rotary_rad = end.rotary_rad;
        move.feed = {FeedRule::tip_speed, 10};
        move.curve_part = part;
        program.moves.push_back(move);
    }
    WriteOptions options;
    options.dialect = Dialect::sinumerik;
    const auto text = write_text(program, nullptr, options);
    ASSERT_TRUE(text) << to_string(text.error());
    const auto read = read_ac(*text);
    ASSERT_TRUE(read) << said(read) << "\n" << *text;
    ASSERT_EQ(read->moves.size(), 3u) << *text;
    ASSERT_EQ(read->curves.size(), 1u);
    for (double u = 0; u <= 5; u += 0.25) {
        const CurvePose a = pose_at(curve, u), b = pose_at(read->curves[0], u);
        EXPECT_LE((a.position_mm - b.position_mm).norm(), 2 * options.precision_mm);
        if (vectors) {
            EXPECT_LE((a.axis.normalized() - b.axis.normalized()).norm(), 1e-6);
        }
        for (std::size_t i = 0; !vectors && i < 2; ++i) EXPECT_NEAR(a.rotary_rad[i], b.rotary_rad[i], 1e-7);
    }
}

TEST(WriteRoundTrip, curves_of_sinumerik_by_vectors) {
    curve_round_trip(OrientationLaw::vector);
}
TEST(WriteRoundTrip, curves_of_sinumerik_by_words) {
    curve_round_trip(OrientationLaw::rotary);
}

}  // namespace
}  // namespace trunnion::nc
