#ifndef ARBORSLAM_APPS_OFFLINE_HTML_TEXT_H_
#define ARBORSLAM_APPS_OFFLINE_HTML_TEXT_H_

#include <string>

namespace arborslam {

/// `text` so that a browser shows it as it is; what is not UTF-8, which names of files need not be, is replaced.
std::string ForHtml(const std::string& text);

/// `bytes` in base 64 (RFC 4648), for a data URL.
std::string Base64(const std::string& bytes);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_HTML_TEXT_H_
