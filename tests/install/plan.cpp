// plan MACHINE_FILE: plans a program that stands in a string and prints the time it takes.
#include <cstddef>
#include <cstdio>

#include <trunnion/files/machine_file.hpp>
#include <trunnion/nc/read.hpp>
#include <trunnion/pipeline/plan.hpp>

namespace {

struct Counter : trunnion::pipeline::PlanObserver {
    std::size_t setpoints = 0;
    void setpoint(const trunnion::motion::Setpoint&) override { ++setpoints; }
};

int refused(const trunnion::Diagnostic& diagnostic) {
    std::fprintf(stderr, "%s\n", trunnion::to_string(diagnostic).c_str());
    return 2;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const auto machine = trunnion::files::read_machine_file(argv[1]);
    if (!machine) return refused(machine.error());
    trunnion::nc::ReadOptions reading;
    reading.machine = &*machine;
    const auto program =
        trunnion::nc::read_program("G21 G90 G94\nG1 X0 Y0 Z0 A0 C0 F600\nX10 A10\nX20 C20\n", "in a string", reading);
    if (!program) return refused(program.error());
    Counter counter;
    const auto summary = trunnion::pipeline::plan(*program, *machine, {}, {}, counter);
    if (!summary) return refused(summary.error());
    std::printf("cycle time %.3f s, %zu setpoints\n", summary->cycle_time_s, counter.setpoints);
    return summary->usable() ? 0 : 1;
}
