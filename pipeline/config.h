#pragma once

#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace slim {

/// What a field is for. Paths are resolved against the config file that names them and stay out of
/// the config hash (contents are hashed instead, see manifest.h).
enum class FieldRole {
    option,      ///< --key value
    positional,  ///< a word on the command line, part of the hash (a shape's name)
    input,       ///< path(s) on the command line
    output,      ///< -o, --output PATH
    path,        ///< --key PATH
};

/// One entry of a stage's configuration, its type erased: the command line, config files, --help,
/// --print-config, the manifest and the config hash are all made from a list of these.
class Field {
public:
    using Target = std::variant<bool*, int*, unsigned*, std::int64_t*, std::uint64_t*, float*,
                                double*, std::string*, std::vector<std::string>*,
                                std::vector<int>*, std::vector<double>*>;
    enum class Kind { boolean, integer, real, text };

    Field(std::string its_key, Target target, std::string its_help, FieldRole its_role)
        : key(std::move(its_key)), help(std::move(its_help)), role(its_role), target_(target) {}

    std::string key;   ///< snake_case, as in TOML
    std::string help;  ///< one line
    FieldRole role;
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    std::vector<std::string> choices;
    bool required = false;  ///< must not be empty
    bool is_part = false;   ///< says which part of the work to do, not what comes out: not hashed

    Kind kind() const;
    bool is_list() const;
    bool is_flag() const { return kind() == Kind::boolean; }
    bool is_path() const { return role >= FieldRole::input; }
    bool is_word() const { return role == FieldRole::positional || role == FieldRole::input; }
    bool empty() const;
    /// "--t-mdl" for t_mdl.
    std::string option() const;
    /// Its place in an error: its key, and its option unless it is a word of the command line.
    Fault place() const;

    /// Parses, checks the range or the choices, and stores. A list takes all items, anything else
    /// exactly one. `where` is the place, key or option of the ConfigError.
    void set(const std::vector<std::string>& items, const Fault& where) const;
    std::vector<std::string> items() const;  ///< the value as text, numbers exact
    std::string toml() const;                ///< the value as TOML
    std::string range_text() const;          ///< "in [1, 3]", "one of a, b" or ""

private:
    Target target_;
};

/// The visitor that a config's visit() is given; gathers its fields in order.
///
///     template <class V> void visit(V&& field) {
///         field.input("inputs", inputs, "point clouds");               // words: paths
///         field.output("output", output, "model to write");            // -o, --output; required
///         field("degree", degree, "polynomial degree", 1, 3);          // --degree, in [1, 3]
///         field("legend", legend, "draw a legend bar");                // --legend, --no-legend
///         field.choice("normals", normals, "...", {"auto", "keep"});   // one of
///         field.path("work", work, "folder for intermediate files");   // --work PATH
///     }
///
/// Members: bool, int, unsigned, int64_t, uint64_t, float, double, std::string, and vectors of
/// std::string, int and double (on the command line a,b,c or repeated).
class FieldList {
public:
    template <class T>
    void operator()(std::string key, T& member, std::string help) {
        add(std::move(key), &member, std::move(help), FieldRole::option);
    }
    template <class T, class Min, class Max>
    void operator()(std::string key, T& member, std::string help, Min min, Max max) {
        Field& field = add(std::move(key), &member, std::move(help), FieldRole::option);
        field.min = static_cast<double>(min);
        field.max = static_cast<double>(max);
    }
    /// One of the given words (each item of a list is one of them).
    template <class T>
    void choice(std::string key, T& member, std::string help, std::vector<std::string> choices) {
        add(std::move(key), &member, std::move(help), FieldRole::option).choices =
            std::move(choices);
    }
    /// Words on the command line that are values, in order; required if empty by default.
    template <class T>
    void positional(std::string key, T& member, std::string help) {
        require(add(std::move(key), &member, std::move(help), FieldRole::positional));
    }
    template <class T>
    void positional(std::string key, T& member, std::string help,
                    std::vector<std::string> choices) {
        Field& field = add(std::move(key), &member, std::move(help), FieldRole::positional);
        field.choices = std::move(choices);
        require(field);
    }
    /// Paths of files to read, as words on the command line; required if empty by default.
    template <class T>
    void input(std::string key, T& member, std::string help) {
        require(add(std::move(key), &member, std::move(help), FieldRole::input));
    }
    /// The same, which may be left out.
    template <class T>
    void optional_input(std::string key, T& member, std::string help) {
        add(std::move(key), &member, std::move(help), FieldRole::input);
    }
    /// --key: which part of the work this call does; not part of the hash, as all parts together
    /// make the same.
    template <class T>
    void part(std::string key, T& member, std::string help) {
        add(std::move(key), &member, std::move(help), FieldRole::option).is_part = true;
    }
    template <class T, class Min, class Max>
    void part(std::string key, T& member, std::string help, Min min, Max max) {
        (*this)(std::move(key), member, std::move(help), min, max);
        fields_.back().is_part = true;
    }
    /// -o PATH; required if empty by default.
    void output(std::string key, std::string& member, std::string help) {
        require(add(std::move(key), &member, std::move(help), FieldRole::output));
    }
    /// -o PATH, which may be left out.
    void optional_output(std::string key, std::string& member, std::string help) {
        add(std::move(key), &member, std::move(help), FieldRole::output);
    }
    /// --key PATH, optional.
    template <class T>
    void path(std::string key, T& member, std::string help) {
        add(std::move(key), &member, std::move(help), FieldRole::path);
    }

    /// Takes --set TABLE.KEY=VALUE: changes to the file that the verb reads. `how` says to who
    /// leaves out the table what is written: "a key of the job is written TABLE.KEY,
    /// such as fit.t_mdl".
    void settings(std::vector<std::string>& member, std::string how) {
        settings_ = &member;
        settings_help_ = std::move(how);
    }
    std::vector<std::string>* settings() const { return settings_; }
    const std::string& settings_help() const { return settings_help_; }

    void append(const Field& field) { fields_.push_back(field); }

    const std::vector<Field>& fields() const { return fields_; }
    const Field* find(std::string_view key) const;

private:
    template <class T>
    Field& add(std::string key, T* member, std::string help, FieldRole role) {
        fields_.emplace_back(std::move(key), Field::Target(member), std::move(help), role);
        return fields_.back();
    }
    static void require(Field& field) { field.required = field.empty(); }

    std::vector<Field> fields_;
    std::vector<std::string>* settings_ = nullptr;
    std::string settings_help_;
};

/// The fields of a config, bound to its members; valid while the config lives where it is.
template <class Config>
FieldList fields_of(Config& config) {
    FieldList list;
    config.visit(list);
    return list;
}

/// ConfigError naming the first required field that is empty.
void check_required(const FieldList& fields);

/// The resolved configuration as TOML, a comment with help and range above each key.
std::string print_config(const FieldList& fields);
/// One `key = value` line for each field that counts (all but paths and parts): what the config
/// hash is of.
std::string canonical_config(const FieldList& fields);

std::vector<std::string> keys_of(const FieldList& fields);

/// That a key is none of these, with the nearest one; with all of them where none is near.
Fault unknown_key(const std::string& key, const FieldList& fields);

}  // namespace slim
