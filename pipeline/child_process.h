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
    double processor_seconds = 0;  ///< of all its threads, in the kernel too
    std::uint64_t peak_memory_bytes = 0;
    /// By read(), from the disk or its cache; mapped files do not count. 0 where the system does
    /// not say.
    std::uint64_t bytes_read = 0;
};

/// The folder this executable lies in; its siblings slim-<verb> lie there too.
std::filesystem::path program_folder();

/// Runs a program to its end, its stdout captured, its stderr and stdin ours. It gets our SIGINT
/// and SIGTERM, and SIGKILL at our end if that comes first: call in the main thread. IoError if it
/// cannot be started.
///
/// errors  file that receives its stderr instead (replaced); empty: ours
ChildResult run_child(const std::vector<std::string>& arguments, const std::string& errors = "");

}  // namespace slim
