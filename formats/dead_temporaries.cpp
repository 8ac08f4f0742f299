#include "formats/dead_temporaries.h"

#include "formats/atomic_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <mutex>
#include <string_view>
#include <sys/file.h>
#include <unistd.h>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// ".tmp.<host>.<space>.", which those end with, before number and random digits, of whose
/// processes the numbers say here whether they live.
std::string_view host_part() {
    const std::string_view suffix = temporary_suffix();
    const std::size_t random = suffix.rfind('.');
    return suffix.substr(0, suffix.rfind('.', random - 1) + 1);
}

/// The number of the process that wrote it if what follows host_part() is "<pid>.<8 hex digits>",
/// else 0.
pid_t process_of(std::string_view rest) {
    pid_t pid = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), pid);
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    const bool is_ours = error == std::errc() && pid > 0 && rest.size() == 9 && rest[0] == '.' &&
                         std::all_of(rest.begin() + 1, rest.end(),
                                     [](unsigned char c) { return std::isxdigit(c) != 0; });
    return is_ours ? pid : 0;
}

bool is_running(pid_t pid) { return ::kill(pid, 0) == 0 || errno != ESRCH; }

/// Of hosts of one name the numbers say nothing; locks do while a file is written.
bool is_locked(const std::string& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file < 0) return true;
    const bool locked = ::flock(file, LOCK_EX | LOCK_NB) != 0;
    ::close(file);
    return locked;
}

/// What lies in a folder, by the name of the file that it was to become.
using Leftovers = std::multimap<std::string, std::string>;

Leftovers leftovers_in(const fs::path& folder) {
    Leftovers out;
    std::error_code none;
    for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none)) {
        const std::string name = at->path().filename().string();
        const std::size_t begin = name.rfind(host_part());
        if (begin == std::string::npos || begin == 0) continue;
        const pid_t pid = process_of(std::string_view(name).substr(begin + host_part().size()));
        if (pid == 0 || pid == ::getpid() || is_running(pid)) continue;
        out.emplace(name.substr(0, begin), name);
    }
    return out;
}

}  // namespace

void remove_dead_temporaries(const std::string& path) {
    static std::mutex mutex;
    static std::map<std::string, Leftovers> folders;
    const fs::path file(path);
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    const std::lock_guard lock(mutex);
    const auto [known, is_new] = folders.try_emplace(folder.string());
    if (is_new) known->second = leftovers_in(folder);
    const auto [first, last] = known->second.equal_range(file.filename().string());
    for (auto at = first; at != last; ++at) {
        const std::string left = (folder / at->second).string();
        if (!is_locked(left)) ::unlink(left.c_str());
    }
    known->second.erase(first, last);
}

}  // namespace slim
