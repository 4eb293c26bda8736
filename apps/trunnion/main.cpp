#include <cstdio>
#include <exception>

#include "commands.hpp"

namespace {

int run(int argc, char** argv) {
    using namespace trunnion::app;
    int status = done;
    CLI::App app("Trunnion: from a 5-axis part program to motion that the machine can really make.", "trunnion");
    app.set_version_flag("--version", "trunnion " TRUNNION_VERSION);
    app.require_subcommand(1);
    app.footer(
        "Lengths, angles, feeds and times carry their unit: 20um, 0.1deg, 20m/min, 1ms.\n"
        "Exit status: 0 done, 1 done but a limit or tolerance is broken, 2 bad input or usage, 3 a fault of ours.");
    add_plan_command(app, status);
    add_check_command(app, status);
    add_predict_command(app, status);
    add_convert_command(app, status);
    add_smooth_command(app, status);
    add_deform_command(app, status);
    add_surface_command(app, status);
    add_report_command(app, status);
    add_machine_command(app, status);
    add_controller_command(app, status);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? done : bad_input;
    }
    return status;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return trunnion::app::own_fault;
    }
}
