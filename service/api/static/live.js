// Shows the page anew, at most once a second, when the service reports a change; what has the focus keeps it.
const main = document.querySelector("main");
const events = new EventSource(main.dataset.events);
let waiting = false;

async function renew() {
  waiting = false;
  if (main.contains(document.activeElement)) return soon();
  const response = await fetch(location.href, { headers: { Accept: "text/html" } });
  const page = new DOMParser().parseFromString(await response.text(), "text/html");
  main.replaceChildren(...page.querySelector("main").childNodes);
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
