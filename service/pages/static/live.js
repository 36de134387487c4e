// Shows the parts of a page anew that have changed, at most once a second, when the service reports a change.
// What has the focus keeps it: its part waits, or all but the form that has it is renewed.
const main = document.querySelector("main");
const events = new EventSource(main.dataset.events);
const sent = new Map(); // by part, as the service wrote it: scripts may have changed it since
let waiting = false;

function parts(page) {
  const live = [...page.querySelectorAll("[data-live]")];
  return live.length ? live : [page.querySelector("main")];
}

parts(document).forEach((part) => sent.set(part.id, part.innerHTML));
const shown = new Map(sent); // the same, but for a form that has the focus

async function renew() {
  waiting = false;
  const response = await fetch(location.href, { headers: { Accept: "text/html" } });
  const page = new DOMParser().parseFromString(await response.text(), "text/html");
  const fresh = new Map(parts(page).map((part) => [part.id, part]));
  for (const part of parts(document)) {
    const now = fresh.get(part.id), text = now?.innerHTML;
    const isNew = shown.get(part.id) !== text;
    if (!now || (sent.get(part.id) === text && !isNew)) continue;
    if (part.contains(document.activeElement)) {
      if (isNew && renewAround(part, now)) shown.set(part.id, text);
      soon();
      continue;
    }
    sent.set(part.id, text);
    shown.set(part.id, text);
    const ticked = new Set([...part.querySelectorAll("input:checked")].map((box) => box.value));
    part.replaceChildren(...now.childNodes);
    part.querySelectorAll("input[type=checkbox]").forEach((box) => (box.checked = ticked.has(box.value)));
  }
  document.dispatchEvent(new Event("renewed"));
}

// Renews a part but for the child whose form has the focus, which so keeps it; whether there is such a form.
function renewAround(part, now) {
  const form = document.activeElement.closest("form");
  const kept = [...part.children].find((child) => form && child.contains(form));
  if (!kept) return false;
  const fresh = [...now.childNodes];
  const same = fresh.findIndex((node) => node.tagName === kept.tagName && node.className === kept.className);
  const place = same < 0 ? fresh.length : same;
  for (const node of [...part.childNodes]) if (node !== kept) node.remove();
  kept.before(...fresh.slice(0, place));
  kept.after(...fresh.slice(place + 1));
  return true;
}

function soon() {
  if (!waiting) setTimeout(renew, 1000);
  waiting = true;
}

events.onmessage = soon;
events.addEventListener("progress", soon);
events.addEventListener("end", () => {
  events.close();
  soon();
});
