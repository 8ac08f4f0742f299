#pragma once

#include <stdexcept>
#include <string>

namespace slim {

/// Exit codes of every executable (CONVENTIONS 2.1).
enum class ExitCode : int {
    ok = 0,
    internal = 1,
    usage = 2,
    bad_data = 3,
    resource = 4,
    numerical = 5,
    incomplete = 6,
    temporary = 75,
    interrupted = 130,
    terminated = 143,
};

/// An error of the outside world: what() names the file, the place, what was expected and what was
/// found. The exit code travels with it.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, const std::string& what) : std::runtime_error(what), code_(code) {}
    ExitCode code() const { return code_; }

private:
    ExitCode code_;
};

/// Usage or configuration: exit 2.
struct ConfigError : Error {
    explicit ConfigError(const std::string& what) : Error(ExitCode::usage, what) {}
};
/// A file that cannot be opened, read or written: exit 3 for input, 4 for a full disk.
struct IoError : Error {
    explicit IoError(const std::string& what, ExitCode code = ExitCode::bad_data)
        : Error(code, what) {}
};
/// A file whose bytes are not what its format promises: exit 3.
struct FormatError : Error {
    explicit FormatError(const std::string& what) : Error(ExitCode::bad_data, what) {}
};
/// Sound bytes that make no model (no points, no extent): exit 3.
struct DataError : Error {
    explicit DataError(const std::string& what) : Error(ExitCode::bad_data, what) {}
};
/// Memory, disk or time limit: exit 4.
struct ResourceError : Error {
    explicit ResourceError(const std::string& what) : Error(ExitCode::resource, what) {}
};
/// A numerical failure above the configured tolerance: exit 5.
struct NumericalError : Error {
    explicit NumericalError(const std::string& what) : Error(ExitCode::numerical, what) {}
};
/// Inputs to merge are missing: exit 6.
struct IncompleteError : Error {
    explicit IncompleteError(const std::string& what) : Error(ExitCode::incomplete, what) {}
};

}  // namespace slim
