#include "trunnion/pipeline/predict.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/controller_file.hpp"
#include "trunnion/files/setup_file.hpp"

#include "planned.hpp"

namespace trunnion::pipeline {
namespace {

constexpr const char* corner = "G21 G90 G94\nG0 X0 Y0 Z0 A10 C0\nG1 X60 F6000\nG1 Y60 C20\nG4 P0.5\nG0 Z50\n";

motion::Controller shipped(const std::string& name) {
    return files::read_controller_file(TRUNNION_SOURCE_DIR "/data/controllers/" + name + ".toml").value();
}

struct Job {
    machine::Machine machine = files::read_machine(test_table, "test.toml").value();
    program::Program program;
    Job() {
        nc::ReadOptions reading;
        reading.machine = &machine;
        program = nc::read_program(corner, "corner.ngc", reading).value();
    }
    motion::Prediction predicted(const std::string& controller, const controller::RowTaker& take_row = {}) const {
        auto out = predict(program, machine, {}, shipped(controller), {}, take_row);
        EXPECT_TRUE(out) << to_string(out.error());
        return out.value_or(motion::Prediction{});
    }
};

TEST(Predict, IdealIsOurOwnPlan) {
    const Job job;
    std::size_t rows = 0;
    const auto ideal = job.predicted("ideal", [&](const motion::PredictedRow&) { ++rows; });
    PlanObserver nobody;
    const auto planned = plan(job.program, job.machine, {}, {}, nobody);
    ASSERT_TRUE(planned);
    EXPECT_EQ(ideal.cycle_time_s, planned->cycle_time_s);
    EXPECT_EQ(ideal.cut_time_s, planned->cut_time_s);
    EXPECT_EQ(ideal.rapid_time_s, planned->rapid_time_s);
    EXPECT_EQ(ideal.dwell_time_s, 0.5);
    EXPECT_EQ(ideal.feed_drops.size(), planned->feed_drops.size());
    EXPECT_EQ(ideal.axes[0].jerk_ratio, planned->axes[0].jerk_ratio);
    EXPECT_EQ(rows, planned->setpoints - 1);
    double lines = 0;
    for (const auto& line : ideal.lines) lines += line.duration_s;
    EXPECT_NEAR(lines, ideal.cycle_time_s, 2e-3);
}

TEST(Predict, EveryShippedControllerTakesTheProgram) {
    const Job job;
    const double ideal = job.predicted("ideal").cycle_time_s, cam = job.predicted("length-over-feed").cycle_time_s;
    const double paper = job.predicted("lavernhe-2006").cycle_time_s,
                 linuxcnc = job.predicted("linuxcnc-2.9").cycle_time_s;
    EXPECT_NEAR(cam, 0.6 + 0.6 + 0.5 + 0.1 * std::cos(10 * degree), 1e-9);  // the rapid is along a tilted tool: Y and Z
    EXPECT_GT(ideal, cam);
    EXPECT_GT(paper, cam);
    EXPECT_GT(linuxcnc, cam);
    EXPECT_LT(paper, 3 * ideal);
    EXPECT_LT(linuxcnc, 3 * ideal);
}

TEST(Predict, FeedAndOverrideCountForEveryController) {
    const Job job;
    for (const char* name : {"ideal", "lavernhe-2006", "length-over-feed", "linuxcnc-2.9"}) {
        const auto time = [&](double override, std::optional<double> feed) {
            PredictionOptions options;
            options.uncertainty = false;
            options.plan.feed_override = override;
            options.plan.feed_mm_s = feed;
            const auto out = predict(job.program, job.machine, {}, shipped(name), options);
            EXPECT_TRUE(out) << to_string(out.error());
            return out ? out->cycle_time_s : 0;
        };
        const double half = time(0.5, {}), whole = time(1, {}), replaced = time(1, 50.0);
        EXPECT_GT(half, whole + 1) << name;
        EXPECT_NEAR(half, replaced, 1e-6) << name;
    }
}

/// What a newcomer sees: full feed on the way in and out, next to nothing at the blend's ends, where A has to turn.
TEST(Predict, TheExampleOfTheBlend) {
    const std::filesystem::path folder = TRUNNION_SOURCE_DIR "/examples/04_prediction";
    const auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml").value();
    const auto setup = files::read_setup_file(folder / "blend_setup.toml").value();
    nc::ReadOptions reading;
    reading.machine = &machine;
    const auto program = nc::read_program_file(folder / "blend.cls", reading);
    ASSERT_TRUE(program) << to_string(program.error());
    PredictionOptions options;
    options.contact_lead_rad = 5 * degree;
    double fastest = 0, apart = 1;
    const auto paper = predict(*program, machine, setup, shipped("lavernhe-2006"), options, [&](const auto& row) {
        fastest = std::max(fastest, row.tip_feed_mm_s);
        if (row.tip_feed_mm_s > 1) apart = std::min(apart, row.contact_feed_mm_s / row.tip_feed_mm_s);
    });
    ASSERT_TRUE(paper) << to_string(paper.error());
    EXPECT_NEAR(fastest, 5000.0 / 60, 1e-6);
    EXPECT_LT(apart, 0.85);  // on the blend the tip is faster than the contact, theory 24 % on a circle
    for (const auto& axis : paper->axes) {
        const bool moves = axis.letter == 'Y' || axis.letter == 'Z' || axis.letter == 'A';
        EXPECT_EQ(axis.velocity_ratio > 1e-6, moves) << axis.letter;
        EXPECT_TRUE(axis.letter != 'A' || axis.velocity_ratio > 0.99);
        EXPECT_LE(axis.jerk_ratio, 1 + 1e-9) << axis.letter;
    }
    ASSERT_FALSE(paper->feed_drops.empty());
    EXPECT_LT(paper->feed_drops.front().feed_min_mm_s, 0.05 * 5000 / 60);
    EXPECT_GT(paper->uncertainty_s, 0);
    const auto old = files::read_controller_file(folder / "old_control.toml").value();
    const auto nineties = predict(*program, machine, setup, old, options);
    ASSERT_TRUE(nineties) << to_string(nineties.error());
    EXPECT_TRUE(std::isnan(nineties->axes[0].jerk_ratio));  // trapezoids
    const auto cam = predict(*program, machine, setup, shipped("length-over-feed"), options);
    EXPECT_GT(nineties->cycle_time_s, cam->cycle_time_s);
}

TEST(Predict, DifferencesAreByLine) {
    const Job job;
    const auto paper = job.predicted("lavernhe-2006"), cam = job.predicted("length-over-feed");
    const auto lines = differences(paper, cam, 2);
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_GE(std::abs(lines[0].time_s - lines[0].other_s), std::abs(lines[1].time_s - lines[1].other_s));
    double sum = 0;
    for (const auto& line : differences(paper, cam, 100)) sum += line.time_s - line.other_s;
    EXPECT_NEAR(sum, paper.cycle_time_s - cam.cycle_time_s, 1e-9);
}

TEST(Predict, JsonHasTheNamesOfTheInterfaces) {
    const Job job;
    const auto paper = job.predicted("lavernhe-2006"), cam = job.predicted("length-over-feed");
    const auto json = nlohmann::json::parse(to_json(paper, job.machine, {}, &cam));
    for (const char* name : {"program", "machine", "controller", "options", "cycle_time_s", "cut_time_s",
                             "rapid_time_s", "dwell_time_s", "tool_change_time_s", "path_length_mm", "uncertainty_s",
                             "axes", "feed_drops", "doubts", "limits", "against", "diagnostics"})
        EXPECT_TRUE(json.contains(name)) << name;
    EXPECT_EQ(json["cycle_time_s"].get<double>(), paper.cycle_time_s);
    EXPECT_NEAR(json["cycle_time_s"].get<double>(),
                json["cut_time_s"].get<double>() + json["rapid_time_s"].get<double>() + 0.5, 1e-9);
    EXPECT_EQ(json["axes"].size(), 5u);
    EXPECT_GT(json["axes"]["X"]["velocity_ratio"].get<double>(), 0);
    EXPECT_GT(json["axes"]["X"]["jerk_ratio"].get<double>(), 0);
    EXPECT_TRUE(nlohmann::json::parse(to_json(cam, job.machine, {}))["axes"]["X"]["jerk_ratio"].is_null());
    EXPECT_GT(json["feed_drops"].size(), 0u);
    EXPECT_FALSE(json["feed_drops"][0]["cause"].get<std::string>().empty());
    EXPECT_EQ(json["against"]["controller"], cam.controller);
    EXPECT_NE(report(paper, job.machine, {}, &cam).find(cam.controller), std::string::npos);
}

TEST(Predict, OfAnotherProgramComparesTimesButNoLines) {
    const Job job;
    const auto now = job.predicted("lavernhe-2006");
    auto before = job.predicted("length-over-feed");
    EXPECT_FALSE(differences(now, before, 3).empty());
    before.program = "before.ngc";
    EXPECT_TRUE(differences(now, before, 3).empty());
    EXPECT_NE(report(now, job.machine, {}, &before).find("before.ngc"), std::string::npos);
}

TEST(Predict, SamplesAsCsv) {
    const Job job;
    const auto path = std::filesystem::temp_directory_path() / "trunnion_prediction.csv";
    auto file = PredictionFile::create(path, job.machine);
    ASSERT_TRUE(file);
    std::size_t rows = 0;
    job.predicted("lavernhe-2006", [&](const motion::PredictedRow& row) { ++rows, file->write(row); });
    ASSERT_TRUE(file->commit());
    std::ifstream in(path);
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line,
              "t_s,X_mm,Y_mm,Z_mm,A_deg,C_deg,line,s_mm,feed_mm_min,contact_feed_mm_min,X_mm_s,Y_mm_s,Z_mm_s,"
              "A_deg_s,C_deg_s,cause");
    std::size_t lines = 0;
    for (; std::getline(in, line); ++lines) EXPECT_EQ(std::ranges::count(line, ','), 15);
    EXPECT_EQ(lines, rows);
    EXPECT_GT(lines, 10u);
    std::filesystem::remove(path);
    EXPECT_EQ(PredictionFile::create("/nowhere/at/all.csv", job.machine).error().code, "FILE0201");
}

}  // namespace
}  // namespace trunnion::pipeline
