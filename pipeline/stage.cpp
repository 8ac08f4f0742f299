#include "pipeline/stage.h"

#include "formats/made_folders.h"
#include "pipeline/command_line.h"
#include "pipeline/console.h"
#include "pipeline/json_text.h"
#include "pipeline/memory_size.h"
#include "pipeline/option_names.h"
#include "pipeline/peak_memory.h"
#include "pipeline/signals.h"
#include "pipeline/told_error.h"
#include "pipeline/version.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

namespace slim {
namespace {

using nlohmann::json;

constexpr int kBrokenPipe = 128 + 13;

void write_stdout(const std::string& text) {
    errno = 0;
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
    if (!written || std::fflush(stdout) != 0) {
        // Nobody reads on, as `| head` does not: the exit code that a shell gives to SIGPIPE.
        if (errno == EPIPE) std::_Exit(kBrokenPipe);
        throw IoError(fmt::format("standard output: cannot write: {}", std::strerror(errno)),
                      ExitCode::resource);
    }
}

/// A coordinate: six digits say where in a room, not where on a map.
std::string coordinate_text(double v) {
    return std::abs(v) >= 1e4 && std::abs(v) < 1e12 ? fmt::format("{:.3f}", v)
                                                    : fmt::format("{:.6g}", v);
}

std::string value_text(const std::string& key, const json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (key.ends_with("bytes") && value.is_number_unsigned())
        return memory_size_text(value.get<std::uint64_t>());
    if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
    if (value.is_object() && value.empty()) return "none";
    if (!value.is_array() || std::any_of(value.begin(), value.end(), [](const json& item) {
            return item.is_structured();
        }))
        return text_of(value);
    std::string text;
    for (const json& item : value)
        text +=
            (text.empty() ? "" : ", ") +
            (item.is_number_float() ? coordinate_text(item.get<double>()) : value_text(key, item));
    return value.empty() ? "none" : text;
}

/// An object's keys in the order of a person: by name, numbers by size (levels 1, 2, ..., 10).
std::vector<std::string> keys_in_order(const json& object) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : object.items()) keys.push_back(key);
    const auto is_number = [](const std::string& key) {
        return !key.empty() && key.find_first_not_of("0123456789") == std::string::npos;
    };
    if (std::all_of(keys.begin(), keys.end(), is_number))
        std::sort(keys.begin(), keys.end(), [](const std::string& a, const std::string& b) {
            return a.size() != b.size() ? a.size() < b.size() : a < b;
        });
    return keys;
}

/// A headline's value. Noise is known to two digits.
std::string headline_text(const Headline& headline, const json& value) {
    if (headline.key.starts_with("noise") && value.is_number_float())
        return fmt::format("{:.2g}", value.get<double>());
    return value_text(headline.key, value);
}

/// The result as "key  value" lines; an object's members are indented below its key, those of
/// several objects below "key 1 of 3".
void append_summary(const json& result, const std::string& indent,
                    const std::vector<Headline>& headlines, std::string& out) {
    std::size_t width = 0;
    for (const auto& [key, value] : result.items()) width = std::max(width, key.size());
    for (const Headline& h : headlines)
        if (const auto at = result.find(h.key); at != result.end() && !at->is_structured())
            out += fmt::format("{}{:<{}}  {}{}{}\n", indent, h.key, width, headline_text(h, *at),
                               h.unit.empty() || at->is_null() ? "" : " ",
                               at->is_null() ? "" : h.unit);
    for (const std::string& key : keys_in_order(result)) {
        const std::string& name = key;
        const json& value = result.at(key);
        const bool is_headline = std::any_of(headlines.begin(), headlines.end(),
                                             [&](const Headline& h) { return h.key == name; });
        if (is_headline && !value.is_structured()) continue;
        if (value.is_object() && !value.empty()) {
            out += indent + key + "\n";
            append_summary(value, indent + "  ", {}, out);
        } else if (value.is_array() && !value.empty() && value[0].is_object()) {
            for (std::size_t i = 0; i < value.size(); ++i) {
                out += fmt::format("{}{} {} of {}\n", indent, key, i + 1, value.size());
                append_summary(value[i], indent + "  ", {}, out);
            }
        } else {
            out += fmt::format("{}{:<{}}  {}\n", indent, key, width, value_text(key, value));
        }
    }
}

Console::Level console_level(const CommonOptions& common) {
    if (common.quiet) return Console::Level::quiet;
    return common.verbose ? Console::Level::verbose : Console::Level::normal;
}

void print_result(const ErasedStage& stage, const CommonOptions& common,
                  const StageContext& context, const json& result) {
    if (common.json) {
        write_stdout(text_of(result) + "\n");
    } else if (stage.description.answers || !common.quiet) {
        std::string text = context.text;
        const bool all_asked = common.verbose && !stage.description.answers;
        if (text.empty() || all_asked)
            append_summary(
                result, "",
                context.headlines.empty() ? stage.description.headlines : context.headlines, text);
        write_stdout(text);
    }
}

json with_run_figures(json result, const std::string& stage, double seconds, std::uint64_t peak) {
    if (!result.is_object()) result = json::object();
    result["stage"] = stage;
    result["version"] = program_version();
    result["seconds"] = seconds;
    result["peak_memory_bytes"] = peak;
    return result;
}

std::string resolved_config(const ErasedStage& stage) {
    const std::string text = stage.resolved ? stage.resolved() : "";
    return text.empty() ? print_config(stage.fields) : text;
}

/// What the options ask for instead of work: true if that was all.
bool answered(const ErasedStage& stage, const CommonOptions& common) {
    if (common.help)
        write_stdout(help_text(stage.description, stage.fields));
    else if (common.version)
        write_stdout(fmt::format("slim-{} {}\n", stage.description.name, program_version()));
    else if (common.print_config)
        write_stdout(resolved_config(stage));
    return common.help || common.version || common.print_config;
}

std::vector<std::string> passed_on(const CommonOptions& common, int threads) {
    std::vector<std::string> options = {fmt::format("--threads={}", threads)};
    if (common.force) options.push_back("--force");
    if (common.quiet) options.push_back("--quiet");
    if (common.verbose) options.push_back("--verbose");
    return options;
}

void work(const ErasedStage& stage, int argc, char** argv) {
    const CommonOptions common = parse_command_line(argc, argv, stage.fields);
    if (answered(stage, common)) return;
    check_required(stage.fields);
    const PeakMeter peak;
    const auto start = std::chrono::steady_clock::now();
    const int threads = resolve_threads(common.threads);
    const ThreadLimit limit(threads);
    Console console("slim-" + stage.description.name, console_level(common));
    StageContext context{console, threads, common.force, stage.description.name,
                         canonical_config(stage.fields), print_config(stage.fields), "",
                         passed_on(common, threads)};
    context.threads_given = common.threads;
    context.given = common.given;
    if (common.verbose) console.info("configuration:\n" + context.config_toml);
    json result = stage.run(context);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    result =
        with_run_figures(std::move(result), stage.description.name, seconds.count(), peak.bytes());
    print_result(stage, common, context, result);
}

bool asks_json(int argc, char** argv) {
    return std::any_of(argv, argv + argc,
                       [](const char* a) { return std::string_view(a) == "--json"; });
}

}  // namespace

bool runs_in_a_job() { return std::getenv(kErrorsByParent) != nullptr; }

namespace {

/// For programs: code and message, and of the fault's parts those that are known.
json json_of_failure(ExitCode code, const std::string& what, const Fault& fault) {
    json out = {{"code", static_cast<int>(code)}, {"message", what}};
    const std::pair<const char*, const std::string&> parts[] = {
        {"file", fault.file}, {"said_by", fault.said_by},   {"key", fault.key},
        {"option", fault.option}, {"expected", fault.expected}, {"found", fault.found},
        {"hint", fault.hint}};
    for (const auto& [name, text] : parts)
        if (!text.empty()) out[name] = text;
    if (fault.line > 0) out["line"] = fault.line;
    return out;
}

int report_failure(const ErasedStage& stage, bool as_json, ExitCode code, const std::string& what,
                   const Fault& fault = {}) {
    remove_empty_made_folders();
    if (!as_json || !runs_in_a_job())
        Console("slim-" + stage.description.name, Console::Level::quiet).error(what);
    if (as_json) {
        const json error = {{"error", json_of_failure(code, what, fault)}};
        const std::string text = text_of(error) + "\n";
        std::fwrite(text.data(), 1, text.size(), stdout);
        std::fflush(stdout);
    }
    return static_cast<int>(code);
}

/// What ran out of memory, and with which option it may take less.
std::string out_of_memory(const FieldList& fields) {
    std::string of, remedy;
    for (const Field& field : fields.fields()) {
        if (field.role == FieldRole::input && of.empty() && !field.empty())
            of = " at work on " + field.items()[0];
        if (field.key == "memory" && !field.empty())
            remedy = ": a smaller --memory than " + field.items()[0] + " takes less at a time";
    }
    return "out of memory" + of + remedy;
}

}  // namespace

std::string summary_text(const json& result, const std::vector<Headline>& headlines) {
    std::string text;
    append_summary(result, "", headlines, text);
    return text;
}

void StageContext::check_stop() const { slim::check_stop(); }

int run_erased_stage(const ErasedStage& stage, int argc, char** argv) {
    share_one_heap_under_a_limit();
    const auto fail = [&](ExitCode code, const std::string& what) {
        return report_failure(stage, asks_json(argc, argv), code, what);
    };
    try {
        watch_signals();  // may find no room for its thread
        work(stage, argc, argv);
        return 0;
    } catch (const ToldError& error) {
        return report_failure(stage, asks_json(argc, argv), error.code(), error.what(),
                              error.parts);
    } catch (const Error& error) {
        const bool usage = error.code() == ExitCode::usage;
        const Fault fault =
            usage ? with_option_names(stage.fields, error.fault(), runs_in_a_job()) : error.fault();
        return report_failure(stage, asks_json(argc, argv), error.code(), message_of(fault), fault);
    } catch (const std::bad_alloc&) {
        return fail(ExitCode::resource, out_of_memory(stage.fields));
    } catch (const std::filesystem::filesystem_error& error) {
        const bool full = error.code() == std::errc::no_space_on_device;
        return fail(full ? ExitCode::resource : ExitCode::bad_data, error.what());
    } catch (const std::system_error& error) {  // threads have no room for their stacks
        const bool exhausted = error.code() == std::errc::resource_unavailable_try_again;
        if (!exhausted)
            return fail(ExitCode::internal, std::string("internal error: ") + error.what());
        return fail(ExitCode::resource, out_of_memory(stage.fields) +
                                            " (for a thread: --threads 1 takes less)");
    } catch (const std::exception& error) {
        return fail(ExitCode::internal, std::string("internal error: ") + error.what());
    }
}

}  // namespace slim
