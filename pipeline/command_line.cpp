#include "pipeline/command_line.h"

#include "pipeline/toml_file.h"
#include "slim/base/error.h"
#include "slim/base/nearest_name.h"
#include "slim/base/parallel.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

namespace slim {
namespace {

/// What was given for one field, still as text.
struct Given {
    std::vector<std::string> items;
    bool flag = false;
    CLI::Option* option = nullptr;
};

void add_common(CLI::App& app, CommonOptions& common, std::string& threads) {
    app.add_flag("-h,--help", common.help);
    app.add_flag("--version", common.version);
    app.add_flag("--print-config", common.print_config);
    app.add_flag("--json", common.json);
    app.add_flag("-q,--quiet", common.quiet);
    app.add_flag("-v,--verbose", common.verbose);
    app.add_flag("--force", common.force);
    app.add_option("--threads", threads);
    app.add_option("--config", common.config);
    app.add_option("--set", common.set)->expected(1)->take_all()->allow_extra_args(false);
}

void add_field(CLI::App& app, const Field& field, Given& given) {
    if (field.is_flag()) {
        given.option =
            app.add_flag(field.option() + ",!--no-" + field.option().substr(2), given.flag);
        given.option->check([](const std::string& text) {
            return text == "true" || text == "false"
                       ? ""
                       : fmt::format("expected true or false, found '{}'", text);
        });
        return;
    }
    std::string names = field.option();
    if (field.role == FieldRole::output) names = "-o," + names;
    if (field.is_word()) names = field.key;
    given.option = app.add_option(names, given.items)->take_all()->allow_extra_args(false);
    if (field.is_word() && field.is_list())
        given.option->expected(-1);
    else
        given.option->expected(1);
}

int read_threads(const std::string& text) {
    int n = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
    if (error != std::errc() || end != text.data() + text.size() || n < 1 || n > kMostThreads)
        throw ConfigError({.option = "--threads",
                           .expected = fmt::format("a whole number from 1 to {}", kMostThreads),
                           .found = "'" + text + "'"});
    return n;
}

/// A list option may be written a,b or given again; of a single value the last one counts.
std::vector<std::string> items_of(const Field& field, const std::vector<std::string>& given) {
    if (!field.is_list()) return {given.back()};
    if (field.is_word()) return given;
    std::vector<std::string> items;
    for (const std::string& text : given)
        for (const std::string& item : list_items(field, text)) items.push_back(item);
    return items;
}

/// Sets the key and returns it; nothing of a file that the verb reads.
std::string apply_set(const std::string& text, const FieldList& fields) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos)
        throw ConfigError({.option = "--set " + text, .expected = "key=value"});
    const std::string key = text.substr(0, equals);
    if (fields.settings() && key.find('.') != std::string::npos) {
        fields.settings()->push_back(text);
        return "";
    }
    const Field* field = fields.find(key);
    if (!field) {
        Fault fault = unknown_key(key, fields);
        if (fields.settings())
            fault = {.problem = fault.problem + "; " + fields.settings_help()};
        fault.option = "--set " + text;
        throw ConfigError(fault);
    }
    field->set(items_of(*field, {text.substr(equals + 1)}),
               {.key = key, .option = "--set " + key});
    return key;
}

/// Whether a file is one that --print-config printed: it names most keys. Nobody writes so many by
/// hand, and of a printed one some lines may have been taken out.
bool is_printed(const std::vector<std::string>& keys, const FieldList& fields) {
    return 2 * keys.size() > fields.fields().size();
}

/// Takes the file's values; what it leaves out stays as it is. Returns the keys that it means: all
/// that a short file names, of a printed one those that are not as by default.
std::vector<std::string> said_by_config(const std::string& file, const FieldList& fields) {
    std::map<std::string, std::vector<std::string>> usual;
    for (const Field& field : fields.fields()) usual[field.key] = field.items();
    std::vector<std::string> keys;
    try {
        keys = apply_config_file(file, fields);
    } catch (const ConfigError& error) {
        Fault fault = error.fault();
        fault.option = "--config";
        throw ConfigError(fault);
    }
    if (is_printed(keys, fields))
        std::erase_if(keys, [&](const std::string& key) {
            return fields.find(key)->items() == usual.at(key);
        });
    return keys;
}

std::vector<std::string> all_options(const FieldList& fields) {
    std::vector<std::string> names = {"--help",  "--version", "--print-config", "--json",
                                      "--quiet", "--verbose", "--force",        "--threads",
                                      "--config", "--set"};
    for (const Field& field : fields.fields()) {
        if (!field.is_word()) names.push_back(field.option());
        if (field.is_flag()) names.push_back("--no-" + field.option().substr(2));
    }
    return names;
}

/// Whether there is a -o that was not given.
bool misses_output(const FieldList& fields, const std::vector<Given>& given) {
    for (std::size_t i = 0; i < given.size(); ++i)
        if (fields.fields()[i].role == FieldRole::output) return given[i].items.empty();
    return false;
}

/// What other programs call an option of ours, or where ours has none; empty of neither.
std::string usual_name(const std::string& name, const FieldList& fields) {
    // As make and others have it.
    if (name.starts_with("-j") && name.find_first_not_of("0123456789", 2) == std::string::npos)
        return "threads are --threads N";
    if (name == "-i" || name == "--input")
        return "files to read are written without an option before them";
    if (name == "--style" && fields.find("clouds"))
        return "a ready style is the first word, before the clouds";
    static const std::pair<const char*, const char*> kUsual[] = {
        {"--resolution", "size"}, {"--width", "size"},  {"--height", "size"}, {"--view", "camera"},
        {"--eye", "camera"},      {"--style", "job"},   {"--map", "aov"},     {"--color-by", "aov"},
        {"--scale", "zoom"},      {"--error", "t_mdl"}, {"--quality", "t_mdl"}};
    for (const auto& [usual, key] : kUsual)
        if (const Field* field = name == usual ? fields.find(key) : nullptr)
            return "did you mean '" + field->option() + "'?";
    return "";
}

void refuse_extras(const std::vector<std::string>& extras, const FieldList& fields,
                   const std::vector<Given>& given) {
    for (const std::string& word : extras) {
        if (word == "--") break;  // what follows are words
        if (word.size() < 2 || word[0] != '-') continue;
        const std::string name = word.substr(0, word.find('='));
        const std::string usual = usual_name(name, fields);
        throw ConfigError({.option = name,
                           .problem = "unknown option",
                           .hint = usual.empty() ? did_you_mean(name, all_options(fields))
                                                 : usual});
    }
    const auto word = std::find_if(extras.begin(), extras.end(),
                                   [](const std::string& extra) { return extra != "--"; });
    if (word == extras.end()) return;
    throw ConfigError(
        fmt::format("unexpected argument '{0}'{1}", *word,
                    misses_output(fields, given) ? "; to write it: -o " + *word : ""));
}

/// Outputs are files or folders that appear whole, which a pipe cannot.
void refuse_standard_output(const FieldList& fields) {
    for (const Field& field : fields.fields())
        if (field.role == FieldRole::output && !field.empty() && field.items()[0] == "-")
            throw ConfigError("-o -: nothing is written to standard output; expected the name of a "
                              "file or folder (./- is one called so)");
}

void apply_given(const FieldList& fields, const std::vector<Given>& given) {
    for (std::size_t i = 0; i < given.size(); ++i) {
        const Field& field = fields.fields()[i];
        if (given[i].option->count() == 0) continue;
        if (field.is_flag())
            field.set({given[i].flag ? "true" : "false"}, field.place());
        else
            field.set(items_of(field, given[i].items), field.place());
    }
}

std::string usage(const StageDescription& stage, const FieldList& fields) {
    std::string line = "Usage: slim " + stage.name;
    for (const Field& field : fields.fields()) {
        std::string word = field.key;
        for (char& c : word) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        if (field.is_word() && field.is_list() && word.ends_with('S')) word.pop_back();
        if (field.is_word() && field.is_list()) word += "...";
        if (field.is_word()) line += field.required ? " " + word : " [" + word + "]";
        if (field.role == FieldRole::output) line += field.required ? " -o PATH" : " [-o PATH]";
    }
    return line + " [options]\n";
}

std::string field_help(const Field& field) {
    std::string name = field.is_word() ? field.key : field.option();
    if (field.role == FieldRole::output) name = "-o, " + name;
    std::string text = field.help;
    const std::string range = field.range_text();
    if (!range.empty()) text += ", " + range;
    if (!field.empty()) {
        std::string value = fmt::format("{}", fmt::join(field.items(), ","));
        text += fmt::format(" (default: {})",
                            field.is_flag() ? (value == "true" ? "on" : "off") : value);
    }
    if (field.is_flag() && field.items()[0] == "true") {
        name = "--no-" + field.option().substr(2);
        text = "turns off what is on by default: " + field.help;
    }
    return fmt::format("  {:<22} {}\n", name, text);
}

/// The parser's "--output: 1 required TEXT missing" as "--output: a value is missing". It has no
/// other place for the option.
ConfigError in_our_words(const CLI::ParseError& error) {
    const std::string message = error.what();
    const std::size_t at = message.find(": 1 required ");
    if (at == std::string::npos) return ConfigError(message);
    return ConfigError({.option = message.substr(0, at), .problem = "a value is missing"});
}

constexpr const char* kCommonHelp = R"(
Every verb:
  --config FILE          read these options from a TOML file (keys as printed by --print-config;
                         what it leaves out stays as by default)
  --set KEY=VALUE        change one of them
  --print-config         print all options as TOML and stop
  --threads N            threads to use, 1 or more (default: SLIM_THREADS, else SLURM_CPUS_PER_TASK, else
                         all of this process's cores)
  --force                do the work even if the output is up to date
  --json                 one JSON object on stdout instead of the summary
  -q, --quiet            no progress and no log; warnings only
  -v, --verbose          the log with times, and the configuration
  -h, --help, --version
Of an option that is given again the last counts; lists (a,b) are joined.
)";

}  // namespace

CommonOptions parse_command_line(int argc, char** argv, const FieldList& fields) {
    CommonOptions common;
    CLI::App app;
    app.set_help_flag();
    app.allow_extras();
    std::string threads;
    add_common(app, common, threads);
    std::vector<Given> given(fields.fields().size());
    for (std::size_t i = 0; i < given.size(); ++i) add_field(app, fields.fields()[i], given[i]);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        throw in_our_words(error);
    }
    if (common.help || common.version) return common;
    if (common.quiet && common.verbose)
        throw ConfigError("--quiet and --verbose: expected one of the two");
    refuse_extras(app.remaining(), fields, given);
    if (app.get_option("--threads")->count() > 0) common.threads = read_threads(threads);
    if (app.get_option("--config")->count() > 0 && common.config.empty())
        throw ConfigError({.option = "--config", .expected = "a file", .found = "''"});
    std::set<std::string> keys;
    if (!common.config.empty())
        for (const std::string& key : said_by_config(common.config, fields)) keys.insert(key);
    for (const std::string& text : common.set) keys.insert(apply_set(text, fields));
    apply_given(fields, given);
    for (std::size_t i = 0; i < given.size(); ++i)
        if (given[i].option->count() > 0) keys.insert(fields.fields()[i].key);
    keys.erase("");
    refuse_standard_output(fields);
    common.given.assign(keys.begin(), keys.end());
    return common;
}

std::string help_text(const StageDescription& stage, const FieldList& fields) {
    std::string text = stage.summary + "\n\n" + usage(stage, fields) + "\n";
    for (const Field& field : fields.fields()) text += field_help(field);
    text += kCommonHelp;
    if (!stage.examples.empty()) text += "\nExamples:\n";
    for (const std::string& example : stage.examples) text += "  " + example + "\n";
    return text;
}

}  // namespace slim
