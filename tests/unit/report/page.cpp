#include "trunnion/report/page.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>
#include <zlib.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/files/output_file.hpp"
#include "trunnion/nc/read.hpp"

#include "detail/blob.hpp"

namespace trunnion::report {
namespace {

struct Planned {
    machine::Machine machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/xyzac-trt.toml").value();
    machine::Setup setup;
    program::Program program;
    Result<pipeline::Summary> summary = fail({});
    std::optional<PlanRecording> observer;

    explicit Planned(std::string_view text, std::string_view name = "part.ngc") {
        nc::ReadOptions reading;
        reading.machine = &machine;
        program = nc::read_program(text, name, reading).value();
        pipeline::PlanOptions options;
        options.setpoint_limits = true;
        observer.emplace(RecordedJob{program, machine, setup}, "plan", options.period_s);
        summary = pipeline::plan(program, machine, setup, options, *observer);
    }
};

constexpr const char* corner = R"(G21 G90 G94
G1 X0 Y0 Z0 A0 C0 F600
G1 X20 A10
G1 Y20 C30
G0 Z30
)";

/// A column of floats as a browser gets it.
std::vector<float> floats(const detail::Blob& blob, const nlohmann::ordered_json& place) {
    std::string bytes(blob.size(), '\0');
    const std::string packed = blob.deflated();
    z_stream stream{};
    inflateInit2(&stream, -15);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = static_cast<uInt>(bytes.size());
    EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
    inflateEnd(&stream);
    EXPECT_EQ(place["type"], "f32");
    std::vector<float> out(place["n"].get<std::size_t>());
    std::memcpy(out.data(), bytes.data() + place["at"].get<std::size_t>(), 4 * out.size());
    return out;
}

TEST(Recording, HoldsEveryRowOfAShortPlan) {
    Planned planned(corner);
    ASSERT_TRUE(planned.summary.has_value()) << planned.summary.error().text;
    const Recording recording = planned.observer->take();
    EXPECT_EQ(recording.rows(), planned.summary->setpoints);
    EXPECT_NEAR(recording.end_s(), planned.summary->cycle_time_s, 1.001e-3);
    detail::Blob blob;
    const auto told = recording.describe(blob);
    EXPECT_EQ(told["buckets"]["time"]["n"], planned.summary->setpoints);
    EXPECT_EQ(told["buckets"]["rows_per_bucket"], 1);
    EXPECT_LT(told["path"]["time"]["n"], planned.summary->setpoints / 5);
    EXPECT_GE(told["path"]["time"]["n"], 4);
    EXPECT_EQ(told["path"]["tip"]["n"], 3 * told["path"]["time"]["n"].get<std::size_t>());
}

/// Axes come to their limits, as the summary says, and stay inside; so does the feed.
TEST(Recording, TellsWhatTheSummaryTells) {
    Planned planned(corner);
    ASSERT_TRUE(planned.summary.has_value());
    const Recording recording = planned.observer->take();
    detail::Blob blob;
    const auto told = recording.describe(blob);
    for (std::size_t a = 0; a < 5; ++a) {
        const machine::Axis& axis = planned.machine.axes[a];
        const double unit = axis.rotary ? std::numbers::pi / 180 : 1;
        const auto peak_share = [&](const char* name, double limit) {
            const auto values = floats(blob, told["buckets"]["axes"][std::string(1, axis.letter)][name]["least"]);
            double peak = 0;
            for (const float value : values) peak = std::max(peak, std::abs(static_cast<double>(value)));
            return peak * unit / limit;
        };
        const pipeline::AxisLoad& load = planned.summary->axes[a];
        EXPECT_LE(peak_share("velocity", axis.feed.velocity), load.velocity_ratio + 1e-4) << axis.letter;
        EXPECT_GE(peak_share("velocity", axis.feed.velocity), load.velocity_ratio - 0.01) << axis.letter;
        EXPECT_LE(peak_share("jerk", axis.feed.jerk), load.jerk_ratio + 1e-3) << axis.letter;
        EXPECT_GE(peak_share("jerk", axis.feed.jerk), load.jerk_ratio - 0.1) << axis.letter;
    }
    const auto deviation = floats(blob, told["buckets"]["deviation"]["least"]);
    const double most_mm = *std::ranges::max_element(deviation) / 1000.0;
    EXPECT_LE(most_mm, planned.summary->tip_deviation_mm + 1e-6);
    EXPECT_GE(most_mm, planned.summary->tip_deviation_mm / 2);
    const auto feed = floats(blob, told["buckets"]["feed"]["least"]);
    const auto programmed = floats(blob, told["buckets"]["programmed"]["least"]);
    for (std::size_t i = 0; i < feed.size(); ++i)
        EXPECT_FALSE(feed[i] > programmed[i] * 1.001 + 0.01) << i;  // rapids have none
}

std::string written(const PageContent& content) {
    const auto path = std::filesystem::temp_directory_path() / ("trunnion-page-" + std::to_string(getpid()) + ".html");
    const auto done = write_page(path, content);
    EXPECT_TRUE(done.has_value()) << done.error().text;
    std::string out = done ? files::read_whole_file(path).value() : "";
    std::filesystem::remove(path);
    return out;
}

class Page : public testing::Test {
  protected:
    void SetUp() override {
        const auto there = page_is_there();
        if (there) return;
        EXPECT_EQ(there.error().code, "REP0001");
        EXPECT_FALSE(there.error().value.empty());
        GTEST_SKIP() << "built without the page: " << there.error().value;
    }
};

std::size_t count(const std::string& text, std::string_view what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
    return found;
}

TEST_F(Page, WhateverTheTextsHoldStaysText) {
    const std::string evil = "</script><script>alert(1)</script><!--\xe2\x80\xa8\xff&\"'";
    Planned planned(std::string(corner) + "(</script><script>alert</script>)\n", "</script><script>alert(3)</script>");
    ASSERT_TRUE(planned.summary.has_value());
    planned.machine.name = evil;
    planned.setup.file = evil;
    const Recording recording = planned.observer->take();
    PageContent content{.program_name = evil, .program_text = evil, .command = evil, .machine = &planned.machine};
    content.setup = &planned.setup;
    content.summary_json = to_json(*planned.summary);
    content.failure = Diagnostic{.code = "X0001", .text = evil, .hint = evil};
    content.events = {{0, 1, evil}};
    content.runs = {&recording};
    PageContent plain = content;
    plain.program_name = plain.program_text = plain.command = "plain";
    plain.failure.reset();
    plain.events.clear();
    const std::string page = written(content), other = written(plain);
    EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
    EXPECT_EQ(page.find("<script>alert"), std::string::npos);
    EXPECT_EQ(page.find("\xe2\x80\xa8", page.find("id=\"content\"")), std::string::npos);
    EXPECT_EQ(count(page, "<script"), count(other, "<script"));
    EXPECT_EQ(count(page, "</script"), count(other, "</script"));
    EXPECT_EQ(page.find("<!--"), std::string::npos);
    const std::size_t begin = page.find("id=\"content\">") + 13, end = page.find("</script>", begin);
    const auto json = nlohmann::json::parse(page.substr(begin, end - begin));
    EXPECT_EQ(json["setup"]["file"].get<std::string>().substr(0, 25), evil.substr(0, 25));
}

TEST_F(Page, AFailedPlanIsShownAsFarAsItCame) {
    // The last block leads A out of its range.
    Planned planned("G21 G90 G94\nG1 X0 Y0 Z0 A0 C0 F600\nG1 X20\nG0 Z30\nG1 A5 F100\nG0 X0\nG1 X200.5 F600\n");
    if (planned.summary.has_value()) GTEST_FAIL() << "the program plans";
    const Recording recording = planned.observer->take();
    PageContent content{.program_name = "part", .machine = &planned.machine, .setup = &planned.setup};
    content.failure = planned.summary.error();
    content.runs = {&recording};
    const std::string page = written(content);
    EXPECT_NE(page.find(planned.summary.error().code), std::string::npos);
}

TEST_F(Page, ThatCannotBeWrittenIsRefused) {
    Planned planned(corner);
    const Recording recording = planned.observer->take();
    PageContent content{.program_name = "part", .machine = &planned.machine, .setup = &planned.setup};
    content.runs = {&recording};
    const auto done = write_page("/nowhere/page.html", content);
    ASSERT_FALSE(done.has_value());
    EXPECT_EQ(done.error().code, "FILE0201");
}

}  // namespace
}  // namespace trunnion::report
