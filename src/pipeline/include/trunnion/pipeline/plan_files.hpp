#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "trunnion/files/output_file.hpp"
#include "trunnion/files/setpoint_file.hpp"
#include "trunnion/pipeline/plan.hpp"

namespace trunnion::pipeline {

/// Where `plan` writes; an empty path is not written.
struct PlanFileNames {
    std::filesystem::path setpoints, path_samples, events;
};

/// Observer that writes setpoints, path samples and events as they come (tables of interfaces.md). Nothing appears
/// under its name before commit().
class PlanFiles : public PlanObserver {
  public:
    static Result<std::unique_ptr<PlanFiles>> create(const PlanFileNames& names, const machine::Machine& machine,
                                                     std::function<bool(double)> progress);

    void setpoint(const motion::Setpoint& row) override;
    void path_sample(const PathSample& sample) override;
    void event(const EventRow& event) override;
    bool progress(double share) override { return !progress_ || progress_(share); }

    Result<void> commit();

  private:
    explicit PlanFiles(const machine::Machine& machine) : machine_(&machine) {}

    const machine::Machine* machine_;
    std::function<bool(double)> progress_;
    std::optional<files::SetpointFile> setpoints_;
    std::optional<files::OutputFile> path_, events_;
};

/// Writes a text as a file that appears complete or not at all.
Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace trunnion::pipeline
