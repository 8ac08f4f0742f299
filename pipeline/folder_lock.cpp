#include "pipeline/folder_lock.h"

#include "formats/made_folders.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <set>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace slim {
namespace {

/// Descriptors that locks of this process hold. Locks are taken and let go by the thread that runs
/// the stages.
std::set<int>& held() {
    static std::set<int> descriptors;
    return descriptors;
}

bool same_file(const struct stat& a, const struct stat& b) {
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// Whether the path still leads to what was opened: its owner may have removed it in between.
bool still_there(const std::string& folder, int descriptor) {
    struct stat opened {
    }, named{};
    return fstat(descriptor, &opened) == 0 && stat(folder.c_str(), &named) == 0 &&
           same_file(opened, named);
}

bool holds_already(const std::string& folder) {
    for (const int descriptor : held())
        if (still_there(folder, descriptor)) return true;
    return false;
}

/// False if another process holds it; what cannot be locked counts as locked.
bool lock(int descriptor, FolderLock::Hold hold) {
    const int how = hold == FolderLock::Hold::alone ? LOCK_EX : LOCK_SH;
    int failed = 0;
    do failed = flock(descriptor, how | LOCK_NB);
    while (failed && errno == EINTR);
    return !failed || errno != EWOULDBLOCK;
}

}  // namespace

int FolderLock::open_folder(const std::string& folder, Hold hold) {
    if (hold == Hold::alone) make_folders(folder);
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0 && hold == Hold::alone)
        throw IoError(
            {.file = folder, .problem = fmt::format("cannot be created: {}", std::strerror(errno))},
                      ExitCode::usage);
    return descriptor;
}

FolderLock::FolderLock(const std::string& folder, Hold hold) {
    if (holds_already(folder)) return;
    for (;;) {
        descriptor_ = open_folder(folder, hold);
        if (descriptor_ < 0) return;
        if (!lock(descriptor_, hold)) {
            close(descriptor_);
            throw Error(ExitCode::temporary,
                        folder +
                            ": another slim is at work in it: wait for its end, or name another "
                            "output or --work folder");
        }
        if (still_there(folder, descriptor_)) break;
        close(descriptor_);
    }
    held().insert(descriptor_);
}

FolderLock::~FolderLock() {
    if (descriptor_ < 0) return;
    held().erase(descriptor_);
    close(descriptor_);
}

}  // namespace slim
