// Runs every kept input through its reader again: fuzz_replay FOLDER…, inputs are FOLDER/<entry>/*. An input that a
// reader does not take as promised ends the program; its name is the last line.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include "entries.hpp"

namespace {

using namespace trunnion::fuzz;
namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

int replay(const Entry& entry, const fs::path& folder) {
    int inputs = 0;
    for (const auto& file : fs::directory_iterator(folder)) {
        fmt::print("{}\n", file.path().string());
        std::fflush(stdout);
        entry.take(bytes_of(file));
        ++inputs;
    }
    return inputs;
}

}  // namespace

int main(int argc, char** argv) {
    int inputs = 0;
    for (int i = 1; i < argc; ++i) {
        for (const auto& folder : fs::directory_iterator(argv[i])) {
            if (!folder.is_directory()) continue;
            const Entry* const entry = entry_named(folder.path().filename().string());
            if (!entry) {
                fmt::print(stderr, "no reader is named {}\n", folder.path().filename().string());
                return 1;
            }
            inputs += replay(*entry, folder);
        }
    }
    fmt::print("{} inputs taken\n", inputs);
    return inputs > 0 ? 0 : 1;
}
