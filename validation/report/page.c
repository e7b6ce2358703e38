/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/report/page.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/bundle.h"

void page_text(const page *p, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '&': fputs("&amp;", p->to); break;
        case '<': fputs("&lt;", p->to); break;
        case '>': fputs("&gt;", p->to); break;
        case '"': fputs("&quot;", p->to); break;
        case '\'': fputs("&#39;", p->to); break;
        default: fputc((unsigned char)*text < ' ' || *text == 127 ? '?' : *text, p->to);
        }
}

void page_count(const page *p, json_int_t value)
{
    char digits[32];
    const int n = snprintf(digits, sizeof digits, "%lld", (long long)value);
    for (int i = 0; i < n; i++) {
        fputc(digits[i], p->to);
        if (digits[i] != '-' && i + 1 < n && (n - 1 - i) % 3 == 0)
            fputc(',', p->to);
    }
}

void page_many(const page *p, size_t count, const char *one)
{
    page_count(p, (json_int_t)count);
    fprintf(p->to, " %s%s", one, count == 1 ? "" : "s");
}

void page_link(const page *p, const char *file)
{
    fputs("<a href=\"", p->to);
    page_text(p, file);
    fputs("\">", p->to);
    page_text(p, file);
    fputs("</a>", p->to);
}

bool page_read(const page *p, const char *file, char **bytes, size_t *size)
{
    ost_error why = {0};
    *bytes = NULL;
    if (p->folder && bundle_find(p->folder, file, bytes, size, &why) != OST_OK && p->unread->status == OST_OK)
        *p->unread = why;
    return *bytes;
}

json_t *page_json(const page *p, const char *file)
{
    char *bytes;
    size_t size;
    if (!page_read(p, file, &bytes, &size))
        return NULL;
    json_t *o = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, NULL);
    free(bytes);
    return o;
}

bool page_has(const page *p, const char *file)
{
    char *bytes;
    size_t size;
    const bool has = page_read(p, file, &bytes, &size);
    if (has)
        free(bytes);
    return has;
}

static void base64(const page *p, const uint8_t *bytes, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t three = (uint32_t)bytes[i] << 16 | (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) |
                               (left > 2 ? bytes[i + 2] : 0u);
        fputc(digit[three >> 18], p->to);
        fputc(digit[three >> 12 & 63], p->to);
        fputc(left > 1 ? digit[three >> 6 & 63] : '=', p->to);
        fputc(left > 2 ? digit[three & 63] : '=', p->to);
    }
}

bool page_picture(const page *p, const char *file, const char *caption)
{
    char *bytes;
    size_t size;
    if (!page_read(p, file, &bytes, &size))
        return false;
    fputs("<figure><figcaption>", p->to);
    page_text(p, caption);
    fputs(" <span class=\"file\">", p->to);
    page_link(p, file);
    fputs("</span></figcaption><img alt=\"", p->to);
    page_text(p, caption);
    fputs("\" src=\"data:image/png;base64,", p->to);
    base64(p, (const uint8_t *)bytes, size);
    fputs("\"></figure>\n", p->to);
    free(bytes);
    return true;
}

void page_begin(const page *p, const char *title)
{
    static const char style[] =
        "body{font:16px/1.5 system-ui,-apple-system,'Segoe UI','DejaVu "
        "Sans',sans-serif;color:#1d2126;background:#fff;max-width:58rem;margin:1.5rem auto;"
        "padding:0 1rem}\n"
        "h1{font-size:1.15rem;font-weight:600;margin:0;color:#444}\n"
        "h2{font-size:1.2rem;margin:2.2rem 0 .4rem;padding-top:.3rem;border-top:1px solid #ccc}\n"
        "h3{font-size:1rem;margin:1.4rem 0 .3rem}\n"
        "p{margin:.5rem 0}a{color:#0b4f9c}\n"
        ".verdict{border:2px solid;border-left-width:12px;padding:.7rem 1rem;margin:.6rem 0 1rem}\n"
        ".verdict ul{margin:.2rem 0}.verdict b{display:block;font-size:1.9rem;line-height:1.2}\n"
        ".equal{border-color:#1c7a3e;background:#f0f8f2}.differ{border-color:#b3261e;background:#fdf1f0}.none{border-"
        "color:#8a5a00;background:#fdf6e7}\n"
        ".scope{font-weight:600}\n"
        ".wide{overflow-x:auto}\n"
        "table{border-collapse:collapse;font-variant-numeric:tabular-nums;width:100%;margin:.4rem 0}\n"
        "td,th{padding:.25rem .6rem .25rem 0;text-align:left;vertical-align:top;border-bottom:1px solid #ddd}\n"
        "th{font-weight:600;border-bottom-color:#999}td.n,th.n{text-align:right;white-space:nowrap}\n"
        "td.bad{font-weight:700;background:#fdf1f0}td.no{color:#555}\n"
        "code,pre{font:.88em/1.45 ui-monospace,'DejaVu Sans Mono',monospace;overflow-wrap:anywhere}\n"
        "pre{background:#f5f5f5;border:1px solid #ddd;padding:.6rem .8rem;white-space:pre-wrap}\n"
        "figure{margin:.6rem 0 "
        "1rem}figcaption{color:#333}img{max-width:100%;height:auto;display:block;margin-top:.2rem}\n"
        ".pair{display:grid;grid-template-columns:1fr 1fr;gap:1rem}\n"
        ".file{font-size:.8em;display:block}\n"
        ".fold>input{position:absolute;opacity:0}.fold>label{cursor:pointer;color:#0b4f9c}.fold>label::before{content:'"
        "\\25B8\\00A0'}\n"
        ".fold>input:checked~label::before{content:'\\25BE\\00A0'}.fold>input:focus-visible~label{outline:2px solid}\n"
        ".fold>div{display:none}.fold>input:checked~div{display:block}\n"
        ".wrap td{overflow-wrap:anywhere}.wrap td:nth-child(2){white-space:nowrap}td.name{min-width:11rem}.facts "
        "th{width:8rem;font-weight:400;color:#444;border-color:#ddd}.facts td.from{width:9rem}\n"
        ".from{font-size:.85em;color:#444}\n"
        ".sign{display:grid;grid-template-columns:1fr 1fr;gap:1rem 2.5rem}.sign div{break-inside:avoid}\n"
        ".sign span{display:block;border-bottom:1px solid #555;height:2.1rem;font-size:.85em;color:#444}\n"
        ".key i{display:inline-block;width:1.1em;height:1.1em;vertical-align:-.2em;margin:0 .35em 0 1em;border:1px "
        "solid #333}\n"
        ".key i.a{background:repeating-linear-gradient(135deg,#c22f27 0 3px,#fff 3px 5px)}.key "
        "i.b{background:#2467bd}\n"
        ".key i.c{background:repeating-linear-gradient(0deg,#e2a400 0 3px,#222 3px 5px)}\n"
        ".changes{table-layout:fixed}.changes td{overflow-wrap:anywhere}.changes th:first-child{width:6.5rem}\n"
        "@media screen and (max-width:38rem){.pair,.sign{grid-template-columns:1fr}.facts tr,.facts th,.facts "
        "td{display:block;width:auto;border:0;padding-bottom:0}"
        ".facts tr{border-bottom:1px solid #ddd}.changes td,.changes th{display:block;width:auto;border:0}.changes "
        "tr{display:block;border-bottom:1px solid #ddd}.changes thead{display:none}}\n"
        "@page{margin:14mm}\n"
        "@media "
        "print{body{margin:0;padding:0;max-width:none;font-size:9.5pt;line-height:1.4}table,pre,.sign{font-size:.9em}"
        "h2,h3{break-after:avoid}figure,tr,pre,.verdict{break-inside:avoid}"
        "thead{display:table-header-group}.wide{overflow:visible}p{orphans:3;widows:3}a{color:inherit}"
        "img{max-height:54mm;width:auto}h2{margin-top:1.3rem}.sign "
        "div,ul{break-inside:avoid}.fold>div{display:block}.fold>label::before{content:none}.fold>label{color:inherit}."
        "fold tr{font-size:.92em}*{-webkit-print-color-adjust:exact;print-color-adjust:exact}}\n";
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
          "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';style-src 'unsafe-inline';img-src "
          "data:\"><title>",
          p->to);
    page_text(p, title);
    fprintf(p->to, "</title>\n<style>\n%s</style></head><body>\n", style);
}

void page_fold_begin(const page *p, const char *id, bool open, const char *label)
{
    fprintf(p->to, "<div class=\"fold\"><input type=\"checkbox\" id=\"%s\"%s><label for=\"%s\">", id,
            open ? " checked" : "", id);
    page_text(p, label);
    fputs("</label>\n", p->to);
}

void page_fold_end(const page *p)
{
    fputs("</div>\n", p->to);
}

void page_end(const page *p)
{
    fputs("</body></html>\n", p->to);
}

void page_shell_word(const page *p, const char *text)
{
    if (text[strspn(text, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789/_.-")] == '\0' && *text) {
        page_text(p, text);
        return;
    }
    page_text(p, "'");
    for (; *text; text++) {
        const char one[2] = {*text, '\0'};
        page_text(p, *text == '\'' ? "'\\''" : one);
    }
    page_text(p, "'");
}
