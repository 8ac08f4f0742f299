#include "pipeline/report/report_record.h"

#include "formats/atomic_file.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"

#include <algorithm>
#include <fstream>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path record_path(const fs::path& folder, const std::string& name) {
    return folder / (name + ".step.json");
}

bool is_as_recorded(const fs::path& folder, const json& files) {
    return std::all_of(files.begin(), files.end(), [&](const json& file) {
        const fs::path path = folder / file.value("name", "");
        std::error_code error;
        return fs::file_size(path, error) == file.value("bytes", std::uintmax_t{0}) && !error &&
               hash_file(path) == file.value("hash", "");
    });
}

}  // namespace

std::vector<fs::path> files_of_step(const fs::path& folder, const std::string& name) {
    std::vector<fs::path> out;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        const std::string file = entry.path().filename().string();
        if (file.starts_with(name + ".") && file != name + ".step.json" && file != name + ".log" &&
            entry.is_regular_file())
            out.push_back(entry.path());
    }
    std::sort(out.begin(), out.end());
    return out;
}

void write_record(const fs::path& folder, const StepRecord& record) {
    json files = json::array();
    for (const fs::path& file : files_of_step(folder, record.name))
        files.push_back({{"name", file.filename().string()},
                         {"bytes", fs::file_size(file)},
                         {"hash", hash_file(file)}});
    const json text = {{"step", record.step},
                       {"run", record.run},
                       {"done", record.done},
                       {"reason", record.reason},
                       {"figures", record.figures},
                       {"files", files},
                       {"run_started", record.run_started}};
    write_file_atomically(record_path(folder, record.name).string(),
                          text_of(text, 1) + "\n",
                          Outlasts::process);
}

std::optional<StepRecord> read_record(const fs::path& folder, const ReportStep& step,
                                      const std::string& name, const std::string& output) {
    std::ifstream in(record_path(folder, name));
    const json text = json_or_discarded(in);
    if (!text.is_object() || !text.contains("figures")) return std::nullopt;
    if (!step.transient && !is_as_recorded(folder, text.value("files", json::array())))
        return std::nullopt;
    StepRecord record;
    record.step = step.name, record.run = step.run, record.name = name, record.output = output;
    record.done = text.value("done", false), record.reason = text.value("reason", "");
    record.figures = text.at("figures");
    record.run_started = text.value("run_started", "");
    // Another row, or the file before it was changed, may have expected another code.
    const bool done = step.expects(record.figures.value("exit", 0));
    if (done != record.done) return std::nullopt;
    return record;
}

}  // namespace slim
