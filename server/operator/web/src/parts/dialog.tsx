// One dialog at a time, the browser's own element: it keeps the focus inside, closes on Escape, gives the focus back.

import { type ComponentChildren, render } from 'preact';
import { useEffect, useRef } from 'preact/hooks';

export interface Asked {
  title: string;
  body: ComponentChildren;
  /** The word on the button that does it; none: there is only "Close". */
  action?: string;
  tone?: 'plain' | 'danger';
  /** Runs when the button is pressed; the dialog stays open with the message when it throws. `left`: it was cancelled meanwhile. */
  run?: (form: FormData, left: AbortSignal) => Promise<void>;
  /** The dialog may not be left without an answer. */
  insist?: boolean;
  wide?: boolean;
}

function Dialog({ asked, done }: { asked: Asked; done: (acted: boolean) => void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const fault = useRef<HTMLParagraphElement>(null);
  const button = useRef<HTMLButtonElement>(null);
  const left = useRef(new AbortController());
  const cancel = () => {
    left.current.abort();
    done(false);
  };
  useEffect(() => {
    dialog.current!.showModal();
    const wanted = dialog.current!.querySelector<HTMLElement>('[data-first]') ?? button.current;
    wanted?.focus();
  }, []);
  const submit = async (event: Event) => {
    event.preventDefault();
    fault.current!.textContent = '';
    button.current!.disabled = true;
    try {
      await asked.run?.(new FormData(event.target as HTMLFormElement), left.current.signal);
      if (!left.current.signal.aborted) done(true);
    } catch (error) {
      if (left.current.signal.aborted) return;
      fault.current!.textContent = (error as Error).message;
      button.current!.disabled = false;
      button.current!.focus();
    }
  };
  return (
    <dialog
      ref={dialog}
      class={asked.wide ? 'dialog dialog-wide' : 'dialog'}
      aria-labelledby="dialog-title"
      onCancel={(event) => {
        event.preventDefault();
        if (!asked.insist) cancel();
      }}
    >
      <form onSubmit={(event) => void submit(event)}>
        <h2 id="dialog-title">{asked.title}</h2>
        <div class="dialog-body">{asked.body}</div>
        <p class="dialog-fault" role="alert" ref={fault} />
        <div class="dialog-buttons">
          {!asked.insist && (
            <button type="button" class="button" onClick={cancel}>
              {asked.action ? 'Cancel' : 'Close'}
            </button>
          )}
          {asked.action && (
            <button ref={button} class={`button ${asked.tone === 'danger' ? 'button-danger' : 'button-main'}`}>
              {asked.action}
            </button>
          )}
        </div>
      </form>
    </dialog>
  );
}

let last: Promise<unknown> = Promise.resolve();

/** Whether it was done; a second one waits for the first. */
export function ask(asked: Asked): Promise<boolean> {
  const mine = last.then(
    () =>
      new Promise<boolean>((resolve) => {
        const host = document.createElement('div');
        document.body.append(host);
        const done = (acted: boolean) => {
          render(null, host);
          host.remove();
          resolve(acted);
        };
        render(<Dialog asked={asked} done={done} />, host);
      }),
  );
  last = mine;
  return mine;
}
