#include "formats/made_folders.h"

#include "formats/message.h"
#include "slim/base/error.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;

std::mutex& guard() {
    static std::mutex mutex;
    return mutex;
}

/// In the order in which they were made: those above first.
std::vector<std::string>& made() {
    static std::vector<std::string> folders;
    return folders;
}

bool is_folder(const fs::path& path) {
    std::error_code none;
    return fs::is_directory(path, none);
}

/// The folders that are missing, the deepest first.
std::vector<fs::path> missing(const fs::path& folder) {
    std::vector<fs::path> out;
    for (fs::path at = folder; !at.empty() && !is_folder(at); at = at.parent_path()) {
        if (at.has_filename()) out.push_back(at);
        if (at == at.parent_path()) break;
    }
    return out;
}

}  // namespace

bool make_folders(const std::string& folder) {
    const std::vector<fs::path> todo = missing(fs::path(folder));
    const std::lock_guard lock(guard());
    bool made_it = false;
    for (auto at = todo.rbegin(); at != todo.rend(); ++at) {
        made_it = ::mkdir(at->c_str(), 0777) == 0;
        if (made_it) {
            made().push_back(fs::absolute(*at).string());
            continue;
        }
        const int error = errno;
        if (is_folder(*at)) continue;  // another process was first
        const bool full = error == ENOSPC || error == EDQUOT;
        throw IoError(
            {.file = folder, .problem = message("cannot make this folder: ", std::strerror(error))},
            full ? ExitCode::resource : ExitCode::usage);
    }
    return made_it;
}

void remove_empty_made_folders() {
    const std::lock_guard lock(guard());
    for (auto at = made().rbegin(); at != made().rend(); ++at) ::rmdir(at->c_str());
    made().clear();
}

}  // namespace slim
