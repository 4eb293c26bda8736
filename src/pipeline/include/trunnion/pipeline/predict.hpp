#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/controller/predict.hpp"
#include "trunnion/files/output_file.hpp"
#include "trunnion/motion/controller.hpp"
#include "trunnion/motion/prediction.hpp"
#include "trunnion/pipeline/plan_options.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::pipeline {

struct PredictionOptions {
    PlanOptions plan;  ///< of kind `ideal`; its feed and feed override count for every kind
    double contact_lead_rad = 0;
    bool uncertainty = true;
};

/// What a control of any kind makes of a program. Kind `ideal` is our own plan(): its rows are setpoints, velocities
/// their differences; what limits the speed is told for whole drops of the feed.
/// Errors: those of controller::predict and of plan().
Result<motion::Prediction> predict(const program::Program& program, const machine::Machine& machine,
                                   const machine::Setup& setup, const motion::Controller& controller,
                                   const PredictionOptions& options, const controller::RowTaker& take_row = {});

/// How two controls differ on one line of the program, all its passes together.
struct LineDifference {
    int line = 0;
    double time_s = 0, other_s = 0;
};
/// Where two predictions of one program differ most, at most `most` lines, the largest difference first. Of two
/// programs: nothing, their lines do not belong together.
std::vector<LineDifference> differences(const motion::Prediction& one, const motion::Prediction& other,
                                        std::size_t most);

/// A dozen lines for a person; the JSON of interfaces.md. `other`: null, or the prediction to compare with.
std::string report(const motion::Prediction& prediction, const machine::Machine& machine,
                   const PredictionOptions& options, const motion::Prediction* other = nullptr);
std::string to_json(const motion::Prediction& prediction, const machine::Machine& machine,
                    const PredictionOptions& options, const motion::Prediction* other = nullptr);

/// Rows of a prediction as CSV:
/// `t_s,X_mm,…,A_deg,…,line,s_mm,feed_mm_min,contact_feed_mm_min,X_mm_s,…,A_deg_s,…,cause`. `feed_mm_min` is the tip's.
/// The contact feed is empty where the tool is not known. Errors as OutputFile.
class PredictionFile {
  public:
    static Result<PredictionFile> create(const std::filesystem::path& path, const machine::Machine& machine);
    void write(const motion::PredictedRow& row);
    Result<void> commit();

  private:
    PredictionFile(files::OutputFile file, const machine::Machine& machine)
        : file_(std::move(file)), machine_(&machine) {}

    files::OutputFile file_;
    const machine::Machine* machine_;
    std::string buffer_;
};

}  // namespace trunnion::pipeline
