#include "pipeline/option_names.h"

#include "pipeline/contains.h"

#include <algorithm>

namespace slim {
namespace {

/// Unit separator, invisible where it is printed; no file's name has it.
constexpr char kMark = '\x1f';

/// Without marks: --key, or in backquotes as it was.
std::string without_marks(const FieldList& fields, const std::string& what) {
    std::string out;
    std::size_t at = 0;
    for (std::size_t mark; (mark = what.find(kMark, at)) != std::string::npos;) {
        const std::size_t close = std::min(what.find(kMark, mark + 1), what.size());
        const std::string key = what.substr(mark + 1, close - mark - 1);
        const Field* field = fields.find(key);
        out += what.substr(at, mark - at) +
               (field && !field->is_word() ? field->option() : "`" + key + "`");
        at = std::min(close + 1, what.size());
    }
    return out + what.substr(at);
}

/// The option that gave the fault's file; empty if it was a word, or the job's.
std::string option_of_file(const FieldList& fields, const std::string& file, bool in_a_job) {
    for (const Field& field : fields.fields()) {
        if (!field.is_path() || !contains(field.items(), file)) continue;
        const bool is_output = field.role == FieldRole::output;
        if (field.is_word() || (is_output && in_a_job)) return "";
        return is_output ? "-o" : field.option();
    }
    return "";
}

}  // namespace

std::string quoted_key(std::string_view key) { return kMark + std::string(key) + kMark; }

Fault with_option_names(const FieldList& fields, Fault fault, bool in_a_job) {
    for (std::string* text : {&fault.problem, &fault.expected, &fault.hint})
        *text = without_marks(fields, *text);
    const bool of_whole_file = fault.line == 0 && fault.said_by.empty();
    if (!fault.option.empty()) return fault;
    if (!fault.file.empty()) {
        if (of_whole_file) fault.option = option_of_file(fields, fault.file, in_a_job);
    } else if (const Field* field = fields.find(fault.key)) {
        fault.option = field->place().option;
    }
    return fault;
}

}  // namespace slim
