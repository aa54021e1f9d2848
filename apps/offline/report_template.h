#ifndef ARBORSLAM_APPS_OFFLINE_REPORT_TEMPLATE_H_
#define ARBORSLAM_APPS_OFFLINE_REPORT_TEMPLATE_H_

#include <string_view>

namespace arborslam {

// The files of apps/offline/report/, which the build turns into strings.
extern const std::string_view kReportHtml;  ///< With the places @TITLE@, @STYLE@, @MAP@, @DATA@ and @SCRIPT@.
extern const std::string_view kReportCss;
extern const std::string_view kReportJs;

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_REPORT_TEMPLATE_H_
