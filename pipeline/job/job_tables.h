#pragma once

#include "pipeline/job/job.h"
#include "pipeline/toml_file.h"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace slim {

// What all readers of a job's tables share: names that must be known, and options made of keys.

/// "job.toml:12", or "job.toml, --set" or "job.toml, command line" of what no line says.
std::string table_place(const std::filesystem::path& file, const TomlTable& table);

/// The table of that name, null without one. ConfigError for a second.
const TomlTable* find_table(const TomlTable& in, const std::string& name,
                            const std::filesystem::path& file);

/// ConfigError for a table of any other name, with the nearest.
void check_tables(const TomlTable& in, const std::vector<std::string>& known,
                  const std::filesystem::path& file);

/// A table of options without those of the file that one of --set takes the place of though it is
/// another: of supersample and antialias, which do not go together, the file's.
TomlTable without_replaced(TomlTable table);

/// The ways to smooth edges that a view's own table leaves without effect: if it says supersample,
/// the antialias of all views, and the other way round.
std::set<std::string> replaced_by_view(const TomlTable& view);

/// Checks what stands above a job's tables: nothing but schema_version, and that it is 1.
/// ConfigError with the line.
void check_top_keys(const TomlTable& root, const std::filesystem::path& file);

/// Puts options of slim-render over a job's: into [render] (aov and name into each [[view]]), and
/// what [[view]] and [[light]] tables say of the same goes.
void override_views(TomlTable& root, const std::vector<TomlValue>& options);

/// A field's value as one option, or one per path.
void append_option(const Field& field, std::vector<std::string>& out);

void append_arguments(JobStep& step, const std::vector<std::string>& arguments);

/// -o, the manifest and the product of a step whose output is known. ConfigError if an earlier step
/// of the job writes that.
void add_step_output(JobStep& step, const Job& job);

/// Checks a table against the fields of a verb and of the job's own part of it, and returns the
/// verb's as command-line options. `owned` are the verb's keys that the job fills in itself.
template <class Config, class Own>
std::vector<std::string> read_options(const TomlTable& table, const std::filesystem::path& file,
                                      Own& own, const std::set<std::string>& owned) {
    Config config;
    FieldList all;
    own.visit(all);
    FieldList verb = fields_of(config);
    for (const Field& field : verb.fields())
        if (!owned.contains(field.key)) all.append(field);
    apply_table(table, all, file);
    std::vector<std::string> options;
    for (const TomlValue& value : table.values)
        if (const Field* field = verb.find(value.key); field && !fields_of(own).find(value.key))
            append_option(*field, options);
    return options;
}

struct NoKeys {
    template <class V>
    void visit(V&&) {}
};

}  // namespace slim
