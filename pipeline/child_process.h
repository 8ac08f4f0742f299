#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// What a finished child process left.
struct ChildResult {
    int exit_code = 0;  ///< 128 + signal if a signal ended it (137: the system ran out of memory)
    std::string output;  ///< everything it wrote on stdout
    double seconds = 0;
    std::uint64_t peak_memory_bytes = 0;
};

/// The folder this executable lies in; its siblings slim-<verb> lie there too.
std::filesystem::path program_folder();

/// Runs a program to its end, its stdout captured, its stderr and stdin ours. It gets our SIGINT
/// and SIGTERM, and SIGKILL at our end if that comes first: call in the main thread. IoError if it
/// cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments);

}  // namespace slim
