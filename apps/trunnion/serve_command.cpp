#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <tpmod/tp_memory.h>
#include <unistd.h>

#include "commands.hpp"
#include "job.hpp"
#include "serve_server.hpp"

namespace trunnion::app {

namespace {

using namespace std::chrono_literals;

constexpr auto between_looks = 200us;

std::atomic<bool> asked_to_end{false};

struct ServeOptions {
    JobOptions job;
    std::string name = TRUNNION_TP_MEMORY;
    bool linuxcnc = false;
};

/// The memory of the module, mapped as long as this lives.
class ModuleMemory {
  public:
    explicit ModuleMemory(const std::string& name) {
        const int file = shm_open(("/" + name).c_str(), O_RDWR, 0);
        if (file < 0) return;
        struct stat size{};
        void* const at = fstat(file, &size) == 0 && size.st_size == sizeof(trunnion_tp_memory)
                             ? mmap(nullptr, sizeof(trunnion_tp_memory), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0)
                             : MAP_FAILED;
        close(file);
        if (at == MAP_FAILED) return;
        memory_ = static_cast<trunnion_tp_memory*>(at);
        if (__atomic_load_n(&memory_->format, __ATOMIC_ACQUIRE) == TRUNNION_TP_FORMAT) return;
        munmap(memory_, sizeof *memory_);
        memory_ = nullptr;
    }
    ~ModuleMemory() {
        if (memory_) munmap(memory_, sizeof *memory_);
    }
    ModuleMemory(const ModuleMemory&) = delete;
    ModuleMemory& operator=(const ModuleMemory&) = delete;
    trunnion_tp_memory* get() const { return memory_; }

  private:
    trunnion_tp_memory* memory_ = nullptr;
};

int serve(const ServeOptions& options) {
    const auto workplace = load_workplace(options.job);
    if (!workplace) return report_failure(workplace.error());
    const ModuleMemory memory(options.name);
    if (!memory.get())
        return report_failure({.code = "RT0100",
                               .text = fmt::format("no module of LinuxCNC has made the shared memory {}", options.name),
                               .hint = "start LinuxCNC with [TRAJ]TPMOD = trunnion_tp; the HAL file may start this "
                                       "command by loadusr"});
    std::signal(SIGINT, [](int) { asked_to_end = true; });
    std::signal(SIGTERM, [](int) { asked_to_end = true; });
    for (OrderServer server(*memory.get(), *workplace); !asked_to_end && !server.module_is_gone();) {
        server.work();
        std::this_thread::sleep_for(between_looks);
    }
    return done;
}

}  // namespace

void add_serve_command(CLI::App& app, int& status) {
    CLI::App* command =
        app.add_subcommand("serve", "plans what LinuxCNC's own queue holds, for its module trunnion_tp");
    const auto options = std::make_shared<ServeOptions>();
    command->add_flag("--linuxcnc", options->linuxcnc, "the control that is served")->required();
    command->add_option("--name", options->name, "of the module's shared memory")->capture_default_str();
    options->job.add_machine_to(*command);
    options->job.add_tolerances_to(*command);
    command->footer("Example (a line of the HAL file):\n  loadusr trunnion serve --linuxcnc -m xyzac-trt");
    command->callback([options, &status] { status = serve(*options); });
}

}  // namespace trunnion::app
