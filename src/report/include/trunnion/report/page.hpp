#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/summary.hpp"
#include "trunnion/report/recording.hpp"

namespace trunnion::report {

/// What a page tells. Every text in it may hold anything: it is shown as text.
struct PageContent {
    std::string program_name, program_text;
    std::string command;  ///< that makes the page again
    const machine::Machine* machine = nullptr;
    const machine::Setup* setup = nullptr;
    std::string summary_json;             ///< pipeline::to_json of the plan; empty: it failed
    std::vector<std::string> other_json;  ///< of the further runs, in their order; empty texts: none
    std::optional<Diagnostic> failure;    ///< why the plan ends where it ends
    std::vector<PlanRecording::TimedEvent> events;
    std::vector<const Recording*> runs;  ///< the plan first
};

/// Whether this program was built with the page's parts. Errors: REP0001 it was not, and why.
Result<void> page_is_there();

/// The page as one HTML file that works offline: style, program and data are inside, data as deflated bytes. Appears
/// complete or not at all. Errors: REP0001, and those of files::OutputFile.
Result<void> write_page(const std::filesystem::path& path, const PageContent& content);

}  // namespace trunnion::report
