#include "slim/base/error.h"

namespace slim {
namespace {

/// "-o x.png", "job.toml:12", "job.toml, --set"; empty of no file.
std::string place_of(const Fault& fault) {
    if (fault.file.empty()) return "";
    std::string text = (fault.option.empty() ? "" : fault.option + " ") + fault.file;
    if (fault.line > 0) return text + ":" + std::to_string(fault.line);
    return fault.said_by.empty() ? text : text + ", " + fault.said_by;
}

void append(std::string& text, const std::string& part) {
    if (part.empty()) return;
    const bool goes_on = text.empty() || part.front() == ' ';
    text += (goes_on ? "" : ": ") + part;
}

}  // namespace

std::string message_of(const Fault& fault) {
    std::string text = place_of(fault);
    append(text, fault.file.empty() && !fault.option.empty() ? fault.option : fault.key);
    append(text, fault.problem);
    if (!fault.expected.empty()) append(text, "expected " + fault.expected);
    const bool has_commas = fault.expected.find_first_of(",;") != std::string::npos;
    if (!fault.found.empty()) text += (has_commas ? "; found " : ", found ") + fault.found;
    if (!fault.hint.empty()) text += " (" + fault.hint + ")";
    return text;
}

Error::Error(ExitCode code, const Fault& fault)
    : std::runtime_error(message_of(fault)),
      code_(code),
      fault_(std::make_shared<const Fault>(fault)) {}

ConfigError ConfigError::at(Fault place) const {
    if (!fault().file.empty()) {
        place.problem = what();
        return ConfigError(place);
    }
    Fault here = fault();
    here.file = std::move(place.file), here.line = place.line;
    here.said_by = std::move(place.said_by);
    here.option.clear();
    return ConfigError(here);
}

}  // namespace slim
