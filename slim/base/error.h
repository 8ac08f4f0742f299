#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

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

/// What an error says, in parts, so that who passes it on need not read its text. Any may be empty.
struct Fault {
    std::string file = {};     ///< that it is of, as it was named
    int line = 0;              ///< of that file, from 1; 0: of none
    std::string said_by = {};  ///< what says it over the file: "--set", "command line"
    std::string key = {};      ///< of the option or value, as in TOML
    std::string option = {};   ///< as a command line has that key, or what named the file: "-o"
    /// What is wrong. One that begins with a blank is a sentence that goes on after key or file.
    std::string problem = {};
    std::string expected = {}, found = {};  ///< found: a text in its quotes
    std::string hint = {};                  ///< what may help: the nearest name
};

/// "job.toml:12: camera: expected front, back, ...; found 'fornt' (did you mean 'front'?)".
std::string message_of(const Fault& fault);

/// A text, not {.key = "a", .problem = "b"}: g++ 12 would take that for a string's two ends, too.
template <class T>
concept Message = std::is_convertible_v<T, std::string>;

/// An error of the outside world: what() names the file, the place, what was expected and what was
/// found. The exit code and its parts travel with it.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, const Fault& fault);
    Error(ExitCode code, const std::string& what) : Error(code, Fault{.problem = what}) {}
    ExitCode code() const { return code_; }
    const Fault& fault() const { return *fault_; }

private:
    ExitCode code_;
    std::shared_ptr<const Fault> fault_;  // shared: copies of an exception must not throw
};

/// Usage or configuration: exit 2.
struct ConfigError : Error {
    explicit ConfigError(const Message auto& what) : Error(ExitCode::usage, std::string(what)) {}
    explicit ConfigError(const Fault& fault) : Error(ExitCode::usage, fault) {}
    /// The same, said of a place in a file: its file, line and said_by. What is of another file
    /// already has all it says for its problem.
    ConfigError at(Fault place) const;
};
/// A file that cannot be opened, read or written: exit 3 for input, 4 for a full disk.
struct IoError : Error {
    explicit IoError(const Message auto& what, ExitCode code = ExitCode::bad_data)
        : Error(code, std::string(what)) {}
    explicit IoError(const Fault& fault, ExitCode code = ExitCode::bad_data)
        : Error(code, fault) {}
};
/// A file whose bytes are not what its format promises: exit 3.
struct FormatError : Error {
    explicit FormatError(const Message auto& what) : Error(ExitCode::bad_data, std::string(what)) {}
    explicit FormatError(const Fault& fault) : Error(ExitCode::bad_data, fault) {}
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
