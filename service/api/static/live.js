// Shows the parts of a page anew that have changed, at most once a second, when the service reports a change.
// What has the focus keeps it.
const main = document.querySelector("main");
const events = new EventSource(main.dataset.events);
const sent = new Map(); // by part, as the service wrote it: scripts may have changed it since
let waiting = false;

function parts(page) {
  const live = [...page.querySelectorAll("[data-live]")];
  return live.length ? live : [page.querySelector("main")];
}

parts(document).forEach((part) => sent.set(part.id, part.innerHTML));

async function renew() {
  waiting = false;
  const response = await fetch(location.href, { headers: { Accept: "text/html" } });
  const page = new DOMParser().parseFromString(await response.text(), "text/html");
  const fresh = new Map(parts(page).map((part) => [part.id, part]));
  for (const part of parts(document)) {
    const now = fresh.get(part.id);
    if (!now || sent.get(part.id) === now.innerHTML) continue;
    if (part.contains(document.activeElement)) {
      soon();
      continue;
    }
    sent.set(part.id, now.innerHTML);
    part.replaceChildren(...now.childNodes);
  }
  document.dispatchEvent(new Event("renewed"));
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
