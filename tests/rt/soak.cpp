// Hours of random motion through the streaming pipeline in one run, part by part, with the checker behind it: every
// limit and tolerance holds, and memory does not grow.
//
//     soak [SIMULATED_S [SEED]]       exit status 0: held
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/verify/check.hpp"

#include "random_walk.hpp"

namespace trunnion {
namespace {

constexpr int lines_of_part = 10'000;
constexpr double dwell_s = 0.02;  ///< between parts: rows at rest, at which a part can be cut off and checked alone
constexpr double tip_tolerance_mm = 0.02, orientation_tolerance_rad = 0.1 * degree;

std::size_t resident_bytes() {
    std::size_t pages = 0, resident = 0;
    std::FILE* const file = std::fopen("/proc/self/statm", "r");
    if (!file) return 0;
    const bool read = std::fscanf(file, "%zu %zu", &pages, &resident) == 2;
    std::fclose(file);
    return read ? resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

/// One walk after another, each reached by a rapid from where the last one ended. Keeps those that are not checked yet.
class WalkParts final : public program::ProgramParts {
  public:
    WalkParts(std::uint64_t seed, const machine::Machine& machine, const machine::Setup& setup)
        : random_(seed), machine_(machine), setup_(setup) {}

    Result<bool> next(program::Program& part) override {
        if (finished) return false;
        program::Program walk = Walk(random_, machine_, setup_, {.arcs = random_.chance(0.5)})();
        if (number_ > 0) begin_where_the_last_ended(walk);
        for (std::size_t k = 0; k < walk.moves.size(); ++k)
            walk.moves[k].line = number_ * lines_of_part + static_cast<std::int32_t>(k) + 1;
        walk.events.push_back({program::EventKind::dwell, true, dwell_s, "G4", walk.moves.size(), 0});
        for (program::Event& event : walk.events)
            event.line = walk.moves[std::min(event.before_move, walk.moves.size() - 1)].line;
        last_ = walk.moves.back();
        part = walk;
        waiting.push_back(std::move(walk));
        ++number_;
        return true;
    }

    bool finished = false;
    std::vector<program::Program> waiting;

  private:
    void begin_where_the_last_ended(program::Program& walk) {
        walk.moves.front().kind = program::MoveKind::rapid;
        program::Move start = last_;
        start.arc = program::no_arc;
        start.exact_stop = false;
        walk.moves.insert(walk.moves.begin(), start);
        for (program::Event& event : walk.events) ++event.before_move;
    }

    Random random_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    program::Move last_;
    std::int32_t number_ = 0;
};

/// Checks a part when the rows of the next one begin.
class Soak final : public pipeline::PlanObserver {
  public:
    Soak(WalkParts& parts, const machine::Machine& machine, const machine::Setup& setup, double wanted_s)
        : parts_(parts), machine_(machine), setup_(setup), wanted_s_(wanted_s) {}

    void setpoint(const motion::Setpoint& row) override {
        const int part = (row.line - 1) / lines_of_part;
        if (part != part_) {
            check_part();
            part_ = part;
        }
        rows_.push_back(row);
        simulated_s_ = row.time_s;
        parts_.finished = simulated_s_ > wanted_s_;
    }

    void check_part() {
        const motion::Setpoint at_rest = rows_.back();
        check_rows();
        rows_.assign(1, at_rest);
        parts_.waiting.erase(parts_.waiting.begin());
        ++checked_;
        note_memory();
    }

    int report() const {
        fmt::print(
            "{} parts, {:.0f} s of motion, {} rows checked; memory at first {:.2f} MB, at last {:.2f} MB, most {:.2f} "
            "MB\n",
            checked_, simulated_s_, checked_rows_, 1e-6 * static_cast<double>(first_bytes_),
            1e-6 * static_cast<double>(last_bytes_), 1e-6 * static_cast<double>(most_bytes_));
        const bool flat = most_bytes_ <= first_bytes_ + 1'000'000;
        if (!flat) fmt::print("memory grows\n");
        return broken_ == 0 && flat ? 0 : 1;
    }

  private:
    void check_rows() {
        const program::Program& program = parts_.waiting.front();
        const auto stands = path::choose_rotary_stands(program, machine_, setup_);
        if (!stands) return tell(to_string(stands.error()));
        const auto poses = verify::programmed_poses(program, machine_, setup_, *stands);
        checked_rows_ += rows_.size();
        const auto table = verify::setpoint_table(std::move(rows_));
        rows_ = {};
        if (!poses || !table) return tell(to_string(poses ? table.error() : poses.error()));
        constexpr double other_matching = 1.03;  // by nearest place, see random_programs.cpp
        verify::CheckOptions options;
        options.tip_tolerance_mm = other_matching * tip_tolerance_mm;
        options.orientation_tolerance_rad = other_matching * orientation_tolerance_rad;
        const auto verdict = verify::check(*table, *poses, machine_, setup_, options);
        if (!verdict) return tell(to_string(verdict.error()));
        const bool matching_fails = turns_back(program);
        for (const auto& b : verdict->broken) {
            const bool of_path = b.what.find("deviation") != b.what.npos || b.what.find("poses") != b.what.npos;
            if (matching_fails && of_path) continue;
            tell(fmt::format("{} {:.6g}, limit {:.6g} at {:.4f} s, line {}", b.what, b.value, b.limit, b.time_s,
                             b.line));
        }
    }

    void tell(const std::string& text) {
        ++broken_;
        fmt::print("part {}: {}\n", checked_, text);
    }

    /// The first tenth lets the buffers grow to what the longest parts need.
    void note_memory() {
        ::malloc_trim(0);
        last_bytes_ = resident_bytes();
        if (simulated_s_ < 0.1 * wanted_s_) first_bytes_ = std::max(first_bytes_, last_bytes_);
        most_bytes_ = std::max(most_bytes_, last_bytes_);
    }

    WalkParts& parts_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    double wanted_s_, simulated_s_ = 0;
    int part_ = 0, checked_ = 0, broken_ = 0;
    std::size_t checked_rows_ = 0, first_bytes_ = 0, last_bytes_ = 0, most_bytes_ = 0;
    std::vector<motion::Setpoint> rows_;
};

int run(double wanted_s, std::uint64_t seed) {
    const machine::Machine machine = wide("ucp710");
    machine::Setup setup;
    setup.workpiece.origin_mm = {10, -20, 50};
    setup.tool.length_mm = 80;
    pipeline::PlanOptions options;
    options.smoothing.tip_tolerance_mm = tip_tolerance_mm;
    options.smoothing.orientation_tolerance_rad = orientation_tolerance_rad;
    WalkParts parts(seed, machine, setup);
    Soak soak(parts, machine, setup, wanted_s);
    fmt::print("{:.0f} s, seed {}\n", wanted_s, seed);
    const auto start = std::chrono::steady_clock::now();
    const auto summary = pipeline::plan(parts, machine, setup, options, soak);
    if (!summary) {
        fmt::print("{}\n", to_string(summary.error()));
        return 1;
    }
    soak.check_part();
    fmt::print("planned and checked in {:.0f} s\n",
               std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return soak.report();
}

}  // namespace
}  // namespace trunnion

int main(int argc, char** argv) {
    const double wanted_s = argc > 1 ? std::strtod(argv[1], nullptr) : 14'400;
    const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
    return trunnion::run(wanted_s, seed);
}
